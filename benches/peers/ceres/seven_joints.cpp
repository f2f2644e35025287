// The joint problem of seven joints with Ceres: one residual block of seven rows a pose, automatic differentiation.
//
//     y_i = k_i tau_i + b_i,     theta_j = s_j q_j + o_j,     tau_i = z_{i-1} . (g x M_i)
//
// M_i is the first moment, about the axis of joint i, of all that it carries. Gravity is taken outward and moments are
// taken inward from frame to frame, which needs few operations on derivatives: no rotation matrix is formed.
//
// With a standard deviation as second argument every joint's position in every pose has an error, theta_j = s_j q_j + o_j + e_j,
// known beforehand to be zero to so many rad: seven more unknowns a pose, which DENSE_SCHUR eliminates.
//
// Reads the folder that benches/speed/exchange.rs describes, finds the fewest iterations that lead from the start there
// to the cosine wanted, solves with as many several times, and prints one line of JSON: median processor time of
// ceres::Solve in s, iterations, cost at the start and at the end, largest cosine at the end.

#include <ceres/ceres.h>
#include <ceres/sphere_manifold.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <memory>
#include <string>
#include <vector>

namespace {

constexpr int kJoints = 7;
constexpr double kCosine = 1e-8;
constexpr int kRuns = 7;
constexpr int kMaxIterations = 50;

using Numbers = std::vector<double>;

// The unknowns, a parameter block each. The first and the last position offset are held, and not among them.
struct Unknowns {
  Numbers gravity, torque_gain, torque_bias, position_gain, position_offset, inertia, placement, displacement;
  // One block of seven a pose; empty where positions are exact.
  std::vector<std::array<double, kJoints>> position_error;
};

struct Pose {
  int placement;  // 0 bare, 1 or 2 the load's
  std::array<double, kJoints> position, torque;
};

struct Data {
  Numbers dh_a, dh_d, dh_cos_alpha, dh_sin_alpha, torque_std;
  double load_mass, first_offset, last_offset;
  Unknowns start;
  std::vector<Pose> poses;
};

// Prediction less measurement of one pose, in standard deviations.
class PoseTorque {
 public:
  PoseTorque(const Data& data, const Pose& pose) : data_(data), pose_(pose) {}

  // Bare; with the load at its first placement; and at its second.
  template <typename T>
  bool operator()(const T* gravity, const T* gain, const T* bias, const T* position_gain, const T* offset,
                  const T* inertia, T* residual) const {
    return Evaluate<T>(gravity, gain, bias, position_gain, offset, inertia, nullptr, nullptr, nullptr, residual);
  }
  template <typename T>
  bool operator()(const T* gravity, const T* gain, const T* bias, const T* position_gain, const T* offset,
                  const T* inertia, const T* placement, T* residual) const {
    return Evaluate<T>(gravity, gain, bias, position_gain, offset, inertia, placement, nullptr, nullptr, residual);
  }
  template <typename T>
  bool operator()(const T* gravity, const T* gain, const T* bias, const T* position_gain, const T* offset,
                  const T* inertia, const T* placement, const T* displacement, T* residual) const {
    return Evaluate<T>(gravity, gain, bias, position_gain, offset, inertia, placement, displacement, nullptr, residual);
  }

 protected:
  template <typename T>
  T Angle(int joint, const T* position_gain, const T* offset, const T* error) const {
    T angle = position_gain[joint] * pose_.position[joint];
    if (joint == 0) {
      angle += data_.first_offset;
    } else if (joint == kJoints - 1) {
      angle += data_.last_offset;
    } else {
      angle += offset[joint - 1];
    }
    if (error != nullptr) angle += error[joint];
    return angle;
  }

  template <typename T>
  bool Evaluate(const T* gravity, const T* gain, const T* bias, const T* position_gain, const T* offset,
                const T* inertia, const T* placement, const T* displacement, const T* error, T* residual) const {
    using std::cos;
    using std::sin;
    // Gravity in each joint's frame after its turn.
    std::array<T, kJoints> cosine, sine, gx, gy;
    T g[3] = {gravity[0], gravity[1], gravity[2]};
    for (int i = 0; i < kJoints; ++i) {
      const T angle = Angle(i, position_gain, offset, error);
      cosine[i] = cos(angle);
      sine[i] = sin(angle);
      gx[i] = cosine[i] * g[0] + sine[i] * g[1];
      gy[i] = cosine[i] * g[1] - sine[i] * g[0];
      g[0] = gx[i];
      g[1] = data_.dh_cos_alpha[i] * gy[i] + data_.dh_sin_alpha[i] * g[2];
      g[2] = data_.dh_cos_alpha[i] * g[2] - data_.dh_sin_alpha[i] * gy[i];
    }
    T mass(0.0);
    T moment[3] = {T(0.0), T(0.0), T(0.0)};
    if (placement != nullptr) {
      mass += data_.load_mass;
      for (int k = 0; k < 3; ++k) moment[k] += data_.load_mass * placement[k];
    }
    if (displacement != nullptr) {
      for (int k = 0; k < 3; ++k) moment[k] += data_.load_mass * displacement[k];
    }
    for (int i = kJoints - 1; i >= 0; --i) {
      mass += inertia[4 * i];
      for (int k = 0; k < 3; ++k) moment[k] += inertia[4 * i + 1 + k];
      // Into the same frame: Trans_z(d) Trans_x(a) Rot_x(alpha).
      const T x = moment[0] + mass * data_.dh_a[i];
      const T y = data_.dh_cos_alpha[i] * moment[1] - data_.dh_sin_alpha[i] * moment[2];
      const T z = data_.dh_sin_alpha[i] * moment[1] + data_.dh_cos_alpha[i] * moment[2] + mass * data_.dh_d[i];
      const T torque = gx[i] * y - gy[i] * x;
      residual[i] = (gain[i] * torque + bias[i] - pose_.torque[i]) / data_.torque_std[i];
      moment[0] = cosine[i] * x - sine[i] * y;
      moment[1] = sine[i] * x + cosine[i] * y;
      moment[2] = z;
    }
    return true;
  }

  const Data& data_;
  const Pose& pose_;
};

// The same with errors of positions, which stand before all other unknowns.
class ShiftedPoseTorque : public PoseTorque {
 public:
  using PoseTorque::PoseTorque;

  template <typename T>
  bool operator()(const T* error, const T* gravity, const T* gain, const T* bias, const T* position_gain,
                  const T* offset, const T* inertia, T* residual) const {
    return Evaluate<T>(gravity, gain, bias, position_gain, offset, inertia, nullptr, nullptr, error, residual);
  }
  template <typename T>
  bool operator()(const T* error, const T* gravity, const T* gain, const T* bias, const T* position_gain,
                  const T* offset, const T* inertia, const T* placement, T* residual) const {
    return Evaluate<T>(gravity, gain, bias, position_gain, offset, inertia, placement, nullptr, error, residual);
  }
  template <typename T>
  bool operator()(const T* error, const T* gravity, const T* gain, const T* bias, const T* position_gain,
                  const T* offset, const T* inertia, const T* placement, const T* displacement, T* residual) const {
    return Evaluate<T>(gravity, gain, bias, position_gain, offset, inertia, placement, displacement, error, residual);
  }
};

// What is known of errors of positions beforehand.
class PositionErrorPrior {
 public:
  explicit PositionErrorPrior(double std) : std_(std) {}

  template <typename T>
  bool operator()(const T* error, T* residual) const {
    for (int i = 0; i < kJoints; ++i) residual[i] = error[i] / std_;
    return true;
  }

 private:
  double std_;
};

// Adds one residual block over the blocks of these sizes.
template <int... kSizes, typename... Blocks>
void AddPose(const Data& data, const Pose& pose, double* error, ceres::Problem& problem, Blocks&... blocks) {
  if (error == nullptr) {
    using Cost = ceres::AutoDiffCostFunction<PoseTorque, kJoints, kSizes...>;
    problem.AddResidualBlock(new Cost(new PoseTorque(data, pose)), nullptr, blocks.data()...);
  } else {
    using Cost = ceres::AutoDiffCostFunction<ShiftedPoseTorque, kJoints, kJoints, kSizes...>;
    problem.AddResidualBlock(new Cost(new ShiftedPoseTorque(data, pose)), nullptr, error, blocks.data()...);
  }
}

void AddPoses(const Data& data, double position_error, Unknowns& x, ceres::Problem& problem) {
  for (std::size_t place = 0; place < data.poses.size(); ++place) {
    const Pose& pose = data.poses[place];
    double* error = x.position_error.empty() ? nullptr : x.position_error[place].data();
    if (pose.placement == 0) {
      AddPose<3, 7, 7, 7, 5, 28>(data, pose, error, problem, x.gravity, x.torque_gain, x.torque_bias, x.position_gain,
                                 x.position_offset, x.inertia);
    } else if (pose.placement == 1) {
      AddPose<3, 7, 7, 7, 5, 28, 3>(data, pose, error, problem, x.gravity, x.torque_gain, x.torque_bias,
                                    x.position_gain, x.position_offset, x.inertia, x.placement);
    } else {
      AddPose<3, 7, 7, 7, 5, 28, 3, 3>(data, pose, error, problem, x.gravity, x.torque_gain, x.torque_bias,
                                       x.position_gain, x.position_offset, x.inertia, x.placement, x.displacement);
    }
    if (error != nullptr) {
      using Cost = ceres::AutoDiffCostFunction<PositionErrorPrior, kJoints, kJoints>;
      problem.AddResidualBlock(new Cost(new PositionErrorPrior(position_error)), nullptr, error);
    }
  }
  problem.SetManifold(x.gravity.data(), new ceres::SphereManifold<3>);
  problem.SetManifold(x.displacement.data(), new ceres::SphereManifold<3>);
}

// Sets the unknowns in place: the problem points at their numbers.
void Assign(const Unknowns& from, Unknowns& to) {
  for (auto block : {&Unknowns::gravity, &Unknowns::torque_gain, &Unknowns::torque_bias, &Unknowns::position_gain,
                     &Unknowns::position_offset, &Unknowns::inertia, &Unknowns::placement, &Unknowns::displacement}) {
    std::copy((from.*block).begin(), (from.*block).end(), (to.*block).begin());
  }
  std::copy(from.position_error.begin(), from.position_error.end(), to.position_error.begin());
}

ceres::Solver::Options Options(int iterations, Unknowns& x) {
  ceres::Solver::Options options;
  options.linear_solver_type = x.position_error.empty() ? ceres::DENSE_NORMAL_CHOLESKY : ceres::DENSE_SCHUR;
  if (!x.position_error.empty()) {
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (auto& error : x.position_error) options.linear_solver_ordering->AddElementToGroup(error.data(), 0);
    for (auto block : {&x.gravity, &x.torque_gain, &x.torque_bias, &x.position_gain, &x.position_offset, &x.inertia,
                       &x.placement, &x.displacement}) {
      options.linear_solver_ordering->AddElementToGroup(block->data(), 1);
    }
  }
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = iterations;
  options.function_tolerance = 0;
  options.gradient_tolerance = 0;
  options.parameter_tolerance = 0;
  return options;
}

// Largest |cosine| between the residual and a column of J. Columns of nothing but rounding errors do not count.
double LargestCosine(ceres::Problem& problem) {
  Numbers residual;
  ceres::CRSMatrix jacobian;
  problem.Evaluate(ceres::Problem::EvaluateOptions(), nullptr, &residual, nullptr, &jacobian);
  Numbers product(jacobian.num_cols), square(jacobian.num_cols);
  double length = 0;
  for (int row = 0; row < jacobian.num_rows; ++row) {
    length += residual[row] * residual[row];
    for (int k = jacobian.rows[row]; k < jacobian.rows[row + 1]; ++k) {
      product[jacobian.cols[k]] += jacobian.values[k] * residual[row];
      square[jacobian.cols[k]] += jacobian.values[k] * jacobian.values[k];
    }
  }
  const double dust = 1e-24 * *std::max_element(square.begin(), square.end());
  double cosine = 0;
  for (int column = 0; column < jacobian.num_cols; ++column) {
    if (square[column] > dust) cosine = std::max(cosine, std::abs(product[column]) / std::sqrt(square[column] * length));
  }
  return cosine;
}

int IterationsNeeded(const Data& data, Unknowns& x, ceres::Problem& problem) {
  int iterations = 0;
  ceres::Solver::Summary summary;
  do {
    Assign(data.start, x);
    ceres::Solve(Options(++iterations, x), &problem, &summary);
  } while (LargestCosine(problem) > kCosine && iterations < kMaxIterations);
  return iterations;
}

// The numbers of a line, and what stands before them.
Numbers Split(const std::string& line, std::string& name) {
  std::istringstream cells(line);
  std::string cell;
  Numbers numbers;
  std::getline(cells, name, ',');
  while (std::getline(cells, cell, ',')) numbers.push_back(std::stod(cell));
  return numbers;
}

std::vector<Pose> ReadPoses(std::ifstream& file) {
  std::vector<Pose> poses;
  std::string line, placement;
  while (std::getline(file, line)) {
    const Numbers numbers = Split(line, placement);
    if (numbers.size() != 2 * kJoints) throw std::runtime_error("poses.csv: expected 15 cells a line");
    poses.push_back({std::stoi(placement), {}, {}});
    std::copy_n(numbers.begin(), kJoints, poses.back().position.begin());
    std::copy_n(numbers.begin() + kJoints, kJoints, poses.back().torque.begin());
  }
  return poses;
}

Data Read(const std::string& folder) {
  std::ifstream constants(folder + "/constants.csv"), poses(folder + "/poses.csv");
  if (!constants || !poses) throw std::runtime_error("no constants.csv and poses.csv in " + folder);
  std::map<std::string, Numbers> table;
  std::string line, name;
  while (std::getline(constants, line)) {
    const Numbers numbers = Split(line, name);
    table[name] = numbers;
  }
  const auto& get = [&table](const char* name) { return table.at(name); };
  const Numbers offset = get("position_offset");
  return {get("dh_a"),
          get("dh_d"),
          get("dh_cos_alpha"),
          get("dh_sin_alpha"),
          get("torque_std"),
          get("load_mass").at(0),
          offset.front(),
          offset.back(),
          {get("gravity"), get("torque_gain"), get("torque_bias"), get("position_gain"),
           Numbers(offset.begin() + 1, offset.end() - 1), get("inertia"), get("placement"), get("displacement"), {}},
          ReadPoses(poses)};
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2 && argc != 3) throw std::runtime_error("usage: seven_joints FOLDER [POSITION_ERROR_RAD]");
  Data data = Read(argv[1]);
  const double position_error = argc == 3 ? std::stod(argv[2]) : 0;
  if (position_error > 0) data.start.position_error.resize(data.poses.size());
  Unknowns x = data.start;
  ceres::Problem problem;
  AddPoses(data, position_error, x, problem);
  const int iterations = IterationsNeeded(data, x, problem);
  Numbers seconds;
  ceres::Solver::Summary summary;
  for (int run = 0; run < kRuns; ++run) {
    Assign(data.start, x);
    const std::clock_t begin = std::clock();
    ceres::Solve(Options(iterations, x), &problem, &summary);
    seconds.push_back(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  }
  std::sort(seconds.begin(), seconds.end());
  std::printf("{\"seconds\":%.9g,\"iterations\":%d,\"initial_cost\":%.17g,\"cost\":%.17g,\"cosine\":%.9g}\n",
              seconds[kRuns / 2], static_cast<int>(summary.iterations.size()) - 1, summary.initial_cost,
              summary.final_cost, LargestCosine(problem));
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
