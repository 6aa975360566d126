#include "building.h"

#include <fstream>
#include <sstream>

#include "../../hal/rig/rig_file.h"
#include "../hil/profile.h"
#include "../solver/decompositions.h"

namespace berth::rths
{

namespace
{

std::string at_line(const std::string &path, int line)
{
    return path + ":" + std::to_string(line) + ": ";
}

/* Rows of three numbers, comments left out, nine rows in all. */
Eigen::Matrix<double, 3 * floors, floors> read_rows(const std::string &path)
{
    std::ifstream file(path);
    if (!file) {
        throw input_error(path + ": cannot be read; the folder must hold case_1.txt to case_4.txt");
    }
    Eigen::Matrix<double, 3 * floors, floors> rows;
    int count = 0;
    std::string text;
    for (int line = 1; std::getline(file, text); line++) {
        text.erase(std::min(text.find('#'), text.size()));
        std::istringstream cells(text);
        std::vector<double> values;
        double value = 0.0;
        while (cells >> value) {
            values.push_back(value);
        }
        if (!cells.eof()) {
            throw input_error(at_line(path, line) + "not a number");
        }
        if (values.empty()) {
            continue;
        }
        if (values.size() != floors || count == rows.rows()) {
            throw input_error(at_line(path, line) +
                              "mass, damping and stiffness take three rows of three numbers each");
        }
        rows.row(count++) = Eigen::Map<const per_floor>(values.data()).transpose();
    }
    if (count != rows.rows()) {
        throw input_error(path + ": has " + std::to_string(count) +
                          " rows of numbers; mass, damping and stiffness take three each");
    }
    return rows;
}

void check_definite(const std::string &path, const char *name, const floor_matrix &matrix)
{
    if (!(symmetric_eigenpairs(0.5 * (matrix + matrix.transpose())).values.minCoeff() > 0.0)) {
        throw input_error(path + ": " + name + " must be positive definite");
    }
}

} // namespace

building read_building(const std::string &path)
{
    const auto rows = read_rows(path);
    building read{rows.topRows<floors>(), rows.middleRows<floors>(floors), rows.bottomRows<floors>()};
    check_definite(path, "M [kg]", read.mass_kg);
    check_definite(path, "C [N s/m]", read.damping_N_s_per_m);
    check_definite(path, "K [N/m]", read.stiffness_N_per_m);
    return read;
}

ground_motion::ground_motion(const std::string &path, double scale)
{
    csv_columns read =
        read_csv_columns(path, {"ground_acceleration_m_per_s2", "m_per_s2", scale, "the header", "--scale"});
    times_s_ = std::move(read.times_s);
    values_m_per_s2_ = std::move(read.values);
    if (times_s_.size() < 2) {
        throw input_error(path + ": an earthquake takes two samples or more");
    }
    for (double &value : values_m_per_s2_) {
        value *= scale;
    }
}

double ground_motion::at(double time_s) const
{
    if (time_s < times_s_.front() || time_s > times_s_.back()) {
        return 0.0;
    }
    while (segment_ > 1 && time_s < times_s_[segment_ - 1]) {
        segment_--;
    }
    while (segment_ + 1 < times_s_.size() && time_s > times_s_[segment_]) {
        segment_++;
    }
    const double from_s = times_s_[segment_ - 1];
    const double part = (time_s - from_s) / (times_s_[segment_] - from_s);
    return (1.0 - part) * values_m_per_s2_[segment_ - 1] + part * values_m_per_s2_[segment_];
}

} // namespace berth::rths
