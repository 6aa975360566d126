/* The public benchmark of virtual real-time hybrid simulation (Silva, Gomez, Maghareh, Dyke, Spencer 2020): a frame
 * of three storeys under an earthquake, whose first floor's spring is the "hardware". Here the frame and the
 * earthquakes, read from the folder of the benchmark's data. */
#ifndef SIM_HAL_RTHS_BUILDING_H
#define SIM_HAL_RTHS_BUILDING_H

#include <Eigen/Core>
#include <string>
#include <vector>

namespace berth::rths
{

constexpr int floors = 3;
using per_floor = Eigen::Matrix<double, floors, 1>;
using floor_matrix = Eigen::Matrix<double, floors, floors>;

struct building {
    floor_matrix mass_kg;
    floor_matrix damping_N_s_per_m;
    floor_matrix stiffness_N_per_m;
};

/* `case_1.txt` to `case_4.txt`: three matrices, `#` starts a comment. Throws input_error with file and line. */
building read_building(const std::string &path);

/* Acceleration of the ground, linear between the record's samples, 0 beyond its ends. */
class ground_motion
{
  public:
    /* CSV, also .gz; `scale` multiplies the record. Throws input_error. */
    ground_motion(const std::string &path, double scale);

    double at(double time_s) const;
    double end_s() const { return times_s_.back(); }

  private:
    std::vector<double> times_s_;
    std::vector<double> values_m_per_s2_;
    mutable std::size_t segment_ = 1; /* the last one that was asked for: time mostly goes on by a step */
};

} // namespace berth::rths

#endif
