// Evaluates evan-el's pacejka: pacejka_reader FILE, rows "kappa alpha gamma Fz V" on standard input.
// The order of the arguments is that of its header.
#include <cstdio>
#include <sstream>

#include "pacejka.hpp"

int main(int, char **argv)
{
    Pacejka tire(argv[1]);
    std::puts("-----");
    double kappa, alpha, gamma, load, speed;
    while (std::cin >> kappa >> alpha >> gamma >> load >> speed) {
        double lateral = -speed * std::tan(alpha), sliding = -speed * kappa;
        std::printf("%.17g %.17g\n",
                    tire.calcLongForceCombined(load, kappa, gamma, alpha, speed, lateral, sliding, lateral),
                    tire.calcLatForceCombined(load, kappa, gamma, alpha, speed, lateral, sliding, lateral));
    }
    return 0;
}
