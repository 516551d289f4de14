// Automatic differentiation through a printed header: derivatives by every input against the printed Jacobian.
// With JET: ceres::Jet; with SYMBOLIC: casadi::SX; otherwise a dual number of this file, and float.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <vector>

#ifdef JET
#include <ceres/jet.h>
using Dual = ceres::Jet<double, 1>;
static Dual dual(double x, double slope) { Dual d(x); d.v[0] = slope; return d; }
static double slope_of(const Dual &x) { return x.v[0]; }
#elif defined(SYMBOLIC)
#include <casadi/casadi.hpp>
using casadi::SX;
#else
template <class T>
struct DualOf {
    T x, d;
    explicit DualOf(double value = 0.0, double slope = 0.0) : x(T(value)), d(T(slope)) {}
};
using Dual = DualOf<double>;
static Dual dual(double x, double slope) { return Dual(x, slope); }
static double slope_of(const Dual &x) { return x.d; }
template <class T> static DualOf<T> operator-(const DualOf<T> &a) { return DualOf<T>(-a.x, -a.d); }
template <class T> static DualOf<T> operator+(const DualOf<T> &a, const DualOf<T> &b) { return DualOf<T>(a.x + b.x, a.d + b.d); }
template <class T> static DualOf<T> operator-(const DualOf<T> &a, const DualOf<T> &b) { return DualOf<T>(a.x - b.x, a.d - b.d); }
template <class T> static DualOf<T> operator*(const DualOf<T> &a, const DualOf<T> &b) { return DualOf<T>(a.x*b.x, a.d*b.x + a.x*b.d); }
template <class T> static DualOf<T> operator/(const DualOf<T> &a, const DualOf<T> &b) { return DualOf<T>(a.x/b.x, (a.d - a.x/b.x*b.d)/b.x); }
template <class T> static bool operator<(const DualOf<T> &a, const DualOf<T> &b) { return a.x < b.x; }
template <class T> static bool operator>(const DualOf<T> &a, const DualOf<T> &b) { return a.x > b.x; }
template <class T> static bool operator<=(const DualOf<T> &a, const DualOf<T> &b) { return a.x <= b.x; }
template <class T> static bool operator>=(const DualOf<T> &a, const DualOf<T> &b) { return a.x >= b.x; }
template <class T> static bool operator==(const DualOf<T> &a, const DualOf<T> &b) { return a.x == b.x; }
template <class T> static DualOf<T> sin(const DualOf<T> &a) { return DualOf<T>(std::sin(a.x), std::cos(a.x)*a.d); }
template <class T> static DualOf<T> cos(const DualOf<T> &a) { return DualOf<T>(std::cos(a.x), -std::sin(a.x)*a.d); }
template <class T> static DualOf<T> tan(const DualOf<T> &a) { const T t = std::tan(a.x); return DualOf<T>(t, (1 + t*t)*a.d); }
template <class T> static DualOf<T> atan(const DualOf<T> &a) { return DualOf<T>(std::atan(a.x), a.d/(1 + a.x*a.x)); }
template <class T> static DualOf<T> acos(const DualOf<T> &a) { return DualOf<T>(std::acos(a.x), -a.d/std::sqrt(1 - a.x*a.x)); }
template <class T> static DualOf<T> exp(const DualOf<T> &a) { return DualOf<T>(std::exp(a.x), std::exp(a.x)*a.d); }
template <class T> static DualOf<T> log(const DualOf<T> &a) { return DualOf<T>(std::log(a.x), a.d/a.x); }
template <class T> static DualOf<T> sqrt(const DualOf<T> &a)
{
    const T root = std::sqrt(a.x);
    return DualOf<T>(root, a.d == 0.0 ? 0.0 : a.d/(2*root));
}
template <class T> static DualOf<T> pow(const DualOf<T> &a, const DualOf<T> &b)
{
    return DualOf<T>(std::pow(a.x, b.x), a.d == 0.0 ? 0.0 : b.x*std::pow(a.x, b.x - 1)*a.d);
}
#endif

#include HEADER

#ifdef SYMBOLIC
template <>
struct TIRE::Choice<SX> {
    static SX choose(const SX &condition, const SX &then, const SX &otherwise)
    {
        return if_else(condition, then, otherwise);
    }
};
#endif

template <class Scalar>
static std::vector<Scalar> members(const TIRE::Forces<Scalar> &forces)
{
    return {forces.Fx, forces.Fy, forces.Mz, forces.Mx, forces.My};
}

template <class Scalar>
static std::vector<Scalar *> members(TIRE::Inputs<Scalar> &inputs)
{
    return {&inputs.kappa, &inputs.alpha, &inputs.gamma, &inputs.Fz, &inputs.p, &inputs.V, &inputs.phit};
}

// NaN is larger than every number.
static void keep_largest(double &largest, double difference)
{
    if (!(difference <= largest))
        largest = difference >= 0.0 ? difference : HUGE_VAL;
}

int main()
{
    double largest = 0.0, largest_float = 0.0;
#ifdef SYMBOLIC
    TIRE::Inputs<SX> symbols;
    std::vector<SX> columns;
    for (SX *member : members(symbols))
        columns.push_back(*member = SX::sym("x" + std::to_string(columns.size())));
    const SX inputs_column = vertcat(columns), forces_column = vertcat(members(TIRE::forces(symbols)));
    casadi::Function derivative("derivative", {inputs_column}, {jacobian(forces_column, inputs_column)});
#endif
    for (int i = 0; i < 60; i++) {
        TIRE::Inputs<double> inputs;
        inputs.kappa = 0.3*std::sin(1.0 + i);
        inputs.alpha = 0.4*std::sin(2.0 + 3*i);
        inputs.gamma = 0.1*std::sin(5.0*i);
        inputs.Fz *= i == 0 ? 0.0 : 1.0 + 0.9*std::sin(7.0*i);
        inputs.V *= i % 3 ? 1.0 : -1.0;
        const auto by_inputs = TIRE::jacobian_inputs(inputs);
        const auto forces = members(TIRE::forces(inputs));
        const auto values = members(inputs);
#ifdef SYMBOLIC
        std::vector<double> point;
        for (const double *value : values)
            point.push_back(*value);
        const casadi::DM matrix = derivative(std::vector<casadi::DM>{casadi::DM(point)})[0];
        for (std::size_t k = 0; k < values.size(); k++)
            for (std::size_t force = 0; force < forces.size(); force++) {
                const double exact = by_inputs[force][k];
                const double size = std::max(std::abs(exact), 1e-3*std::abs(forces[force]) + 1e-6);
                keep_largest(largest, std::abs(double(matrix(force, k)) - exact)/size);
            }
#else
        for (std::size_t k = 0; k < values.size(); k++) {
            TIRE::Inputs<Dual> seeded;
            const auto seeds = members(seeded);
            for (std::size_t j = 0; j < values.size(); j++)
                *seeds[j] = dual(*values[j], j == k ? 1.0 : 0.0);
            const auto results = members(TIRE::forces(seeded));
            for (std::size_t force = 0; force < forces.size(); force++) {
                const double exact = by_inputs[force][k];
                const double size = std::max(std::abs(exact), 1e-3*std::abs(forces[force]) + 1e-6);
                const double difference = std::abs(slope_of(results[force]) - exact)/size;
                keep_largest(largest, difference);
            }
        }
#ifndef JET
        for (std::size_t k = 0; k < values.size(); k++) {
            TIRE::Inputs<DualOf<float>> seeded;
            const auto seeds = members(seeded);
            for (std::size_t j = 0; j < values.size(); j++)
                *seeds[j] = DualOf<float>(i < 2 && j < 2 ? 0.0 : *values[j], j == k ? 1.0 : 0.0);
            for (const auto &force : members(TIRE::forces(seeded)))
                if (!std::isfinite(force.d)) // without load, at zero slip
                    largest_float = HUGE_VAL;
        }
        TIRE::Inputs<float> single;
        const auto rounded = members(single);
        for (std::size_t j = 0; j < values.size(); j++)
            *rounded[j] = static_cast<float>(*values[j]);
        const auto floats = members(TIRE::forces(single));
        for (std::size_t force = 0; force < forces.size(); force++)
            keep_largest(largest_float, std::abs(double(floats[force]) - forces[force])/(force < 2 ? 3e3 : 3e2));
#endif
#endif
    }
    std::printf("derivatives %.3g, float %.3g\n", largest, largest_float);
    return largest < 1e-9 && largest_float < 1e-4 ? 0 : 1;
}
