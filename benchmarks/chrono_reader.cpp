// Evaluates Project Chrono's ChPac02Tire alone: chrono_reader FILE, rows "kappa alpha gamma Fz" on standard input.
// What the class uses of the rest of Chrono is declared here; the rows call CalcFxyMz as its Advance does.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#define CH_VEHICLE_API

// The fit of a line of vertical stiffness; the forces of the rows do not read it.
namespace Eigen {
struct VectorXd : std::vector<double> {
    explicit VectorXd(size_t size) : std::vector<double>(size) {}
    double &operator()(size_t i) { return at(i); }
};
struct MatrixXd {
    std::vector<double> values;
    MatrixXd(size_t rows, size_t columns) : values(rows * columns) {}
    double &operator()(size_t i, size_t j) { return values.at(2 * i + j); }
    const MatrixXd &householderQr() const { return *this; }
    VectorXd solve(const VectorXd &) const { return VectorXd(2); }
};
}  // namespace Eigen

namespace chrono {

const double CH_PI = 3.141592653589793, CH_PI_2 = CH_PI / 2, CH_1_3 = 1.0 / 3.0;
const double CH_DEG_TO_RAD = CH_PI / 180, CH_RAD_TO_DEG = 180 / CH_PI;

struct ChVector2d {
    double values[2] = {0, 0};
    double &x() { return values[0]; }
    double &y() { return values[1]; }
    double &operator[](int i) { return values[i]; }
    double operator[](int i) const { return values[i]; }
    double Length() const { return std::hypot(values[0], values[1]); }
    void Normalize() { *this *= 1 / Length(); }
    void operator*=(double factor) { values[0] *= factor, values[1] *= factor; }
};

struct ChVector3d {
    double values[3];
    ChVector3d(double x = 0, double y = 0, double z = 0) : values{x, y, z} {}
    double x() const { return values[0]; }
    double y() const { return values[1]; }
    double z() const { return values[2]; }
    double Length() const { return std::sqrt(x() * x() + y() * y() + z() * z()); }
};

template <typename Number>
int ChSignum(Number x) { return (x > 0) - (x < 0); }

template <typename Number, typename Limit>
void ChClampValue(Number &x, Limit low, Limit high) { x = std::min<Number>(std::max<Number>(x, low), high); }

// A table of the file; the forces of the rows do not read it.
struct ChFunctionInterp {
    std::map<double, double> points;
    void AddPoint(double x, double y) { points[x] = y; }
    double GetVal(double) const { return 0; }
    const std::map<double, double> &GetTable() const { return points; }
};

struct ChFunctionSineStep {
    static double Eval(double, double, double, double, double) { return 1; }
};

template <typename Number = double>
struct ChMatrix33 {
    explicit ChMatrix33(int) {}
    ChVector3d GetAxisY() const { return {}; }
};

namespace vehicle {

enum VehicleSide { LEFT, RIGHT };
struct ChTerrain {};
struct WheelState {
    int rot = 0;
    ChVector3d pos, lin_vel;
    double omega = 0;
};
struct System {
    ChVector3d GetGravitationalAcceleration() const { return {0, 0, -9.81}; }
};
struct Spindle {
    System system;
    System *GetSystem() { return &system; }
};
struct ChWheel {
    Spindle spindle;
    Spindle *GetSpindle() { return &spindle; }
    WheelState GetState() const { return {}; }
    VehicleSide GetSide() const { return LEFT; }
};
struct Frame {
    ChVector3d TransformDirectionParentToLocal(const ChVector3d &v) const { return v; }
};

class ChTire {
  public:
    virtual ~ChTire() {}
    virtual void Initialize(std::shared_ptr<ChWheel> wheel) { m_wheel = wheel; }
    virtual std::string GetTemplateName() const = 0;
    virtual double GetRadius() const = 0;
    virtual double GetWidth() const = 0;
    virtual double GetDeflection() const = 0;
    virtual double GetVisualizationWidth() const = 0;

  protected:
    virtual void Synchronize(double, const ChTerrain &) {}
    virtual void Advance(double) {}
    virtual void GetInternalStates(ChVector2d &) const {}
    virtual void SetInternalStates(const ChVector2d &) {}
    void ConstructAreaDepthTable(double, ChFunctionInterp &) {}
    bool DiscTerrainCollision(int, const ChTerrain &, ChVector3d, ChVector3d, double, double, ChFunctionInterp &,
                              Frame &, double &, float &) { return false; }
    void CalculateKinematics(const WheelState &, const Frame &) {}
    std::shared_ptr<ChWheel> m_wheel;
    bool m_verbose = false;
    double m_stepsize = 1e-3;
    int m_collision_type = 0;
};

class ChForceElementTire : public ChTire {
  public:
    explicit ChForceElementTire(const std::string &) {}
    virtual double GetNormalStiffnessForce(double) const = 0;
    virtual double GetNormalDampingForce(double, double) const = 0;

  protected:
    struct {
        bool in_contact;
        Frame frame;
        ChVector3d vel;
        double normal_force, depth;
    } m_data;
    struct {
        ChVector3d force, point, moment;
    } m_tireforce;
    ChFunctionInterp m_areaDep;
};

}  // namespace vehicle
}  // namespace chrono

#include "ChPac02Tire.cpp"

class Tire : public chrono::vehicle::ChPac02Tire {
  public:
    explicit Tire(const std::string &file) : ChPac02Tire("tire"), file(file)
    {
        m_allow_mirroring = false;
        Initialize(std::make_shared<chrono::vehicle::ChWheel>());
    }
    void SetMFParams() override { SetMFParamsByFile(file); }
    void print(double kappa, double alpha, double gamma, double load)
    {
        double Fx = 0, Fy = 0, Mz = 0;
        m_states.mu_scale = 1;
        m_states.Fz0_prime = m_par.FNOMIN * m_par.LFZO;
        m_states.dfz0 = (load - m_states.Fz0_prime) / m_states.Fz0_prime;
        m_states.Pi0_prime = m_par.IP_NOM * m_par.LIP;
        m_states.dpi = (m_par.IP - m_states.Pi0_prime) / m_states.Pi0_prime;
        CalcFxyMz(Fx, Fy, Mz, kappa, alpha, load, gamma);
        std::printf("%.17g %.17g %.17g\n", Fx, Fy, Mz);
    }

  private:
    std::string file;
};

int main(int, char **argv)
{
    Tire tire(argv[1]);
    std::puts("-----");
    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream row(line);
        double kappa, alpha, gamma, load;
        if (row >> kappa >> alpha >> gamma >> load) tire.print(kappa, alpha, gamma, load);
    }
    return 0;
}
