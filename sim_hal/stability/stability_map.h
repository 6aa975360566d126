/* Largest |z| of the loop over two parameters of a rig; of a loop that changes on schedule, the largest of all
 * instants at each point. */
#ifndef SIM_HAL_STABILITY_STABILITY_MAP_H
#define SIM_HAL_STABILITY_STABILITY_MAP_H

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "../../hal/rig/keys.h"
#include "../../hal/rig/rig.h"
#include "../arm/linear_arm.h"
#include "scheduled_rig.h"
#include "spectrum.h"

namespace berth
{

/* Values from..to in equal steps, both ends included. */
struct map_axis {
    std::string name; /* a key of the rig, or one of the two below */
    double from = 0.0;
    double to = 1.0;
    int count = 2;

    double value(int i) const { return i + 1 == count ? to : from + (to - from) * i / (count - 1); }
};

/* Axes of the coupled system, see map_point_of(). */
constexpr const char *frequency_ratio_axis = "omega_per_omega_M";
constexpr const char *damping_ratio_axis = "zeta";

/* What changes along the axes: the object's stiffness and damping or its mass and damping so that the coupled system
 * gets the frequency and damping of the point, or two keys. */
enum class map_kind { elasticity, mass, keys };

/* What a compensation that has a model is told at each point: that point; the rig that is varied, wherever the point
 * is; or the point with one thing wrong by its tolerance, the worst of all such. */
enum class told_model { of_the_point, of_the_rig, with_tolerances };

struct map_request {
    berth::rig rig;
    told_model told = told_model::of_the_point;
    map_kind kind = map_kind::elasticity;
    map_axis x;
    map_axis y;
    bool has_flight = false; /* the object is a tool's, held to the material: where it decays there but grows away
                                from it, that counts */
    std::optional<arm_mode> reduced_to; /* in place of the arm at each point, whose object stays */
    double amplitude_m = 0.0; /* greater than 0: effects of size are replaced by what is equivalent at each point */

    std::size_t points() const { return static_cast<std::size_t>(x.count) * static_cast<std::size_t>(y.count); }
};

/* Why a point has no value. */
enum class point_state {
    possible,
    not_passive, /* needs a negative stiffness, damping or mass */
    invalid      /* the rig would be refused, such as a dead time below one period */
};

/* Puts a rig to points of a map, again and again. */
class map_point_setter
{
  public:
    explicit map_point_setter(const map_request &request);

    point_state set(double x, double y);
    const berth::rig &rig() const { return rig_; }

    /* Each loop of the point: with each model that it may have been told, at each instant of its schedule. */
    template <typename F>
    void for_each_loop(F &&look)
    {
        for_each_model([&](const berth::rig &told) {
            if (!is_scheduled_) {
                look(told);
                return;
            }
            for (const double at_s : instants_s_) {
                look(rig_at(told, at_s));
            }
        });
    }

    /* The rig of the point with each model that its loop may have been told. */
    template <typename F>
    void for_each_model(F &&look)
    {
        const hardware_model right = rig_.firmware.hardware;
        for (const model_error &error : errors_) {
            rig_.firmware.hardware.setpoint_to_motion_ms += (error.dead_time - 1.0) * right.setpoint_to_motion_ms;
            rig_.firmware.hardware.loop_delay_ms += (error.dead_time - 1.0) * right.setpoint_to_motion_ms;
            rig_.firmware.hardware.stiffness_N_per_m *= error.stiffness;
            rig_.firmware.hardware.mass_kg *= error.mass;
            look(static_cast<const berth::rig &>(rig_));
            rig_.firmware.hardware = right;
        }
    }

  private:
    struct model_error { /* factors */
        double dead_time = 1.0;
        double stiffness = 1.0;
        double mass = 1.0;
    };
    static std::vector<model_error> errors_of(const map_request &request);
    point_state set_coupled(double frequency_ratio, double damping_ratio);
    point_state set_point(double x, double y);

    map_kind kind_;
    told_model told_;
    berth::rig rig_;
    hardware_model model_of_the_rig_;
    std::vector<model_error> errors_;
    bool is_scheduled_ = false;
    std::vector<double> instants_s_;
    const rig_key *x_key_;
    const rig_key *y_key_;
};

/* Rows of y, in each all x; NaN where there is no value. The same bits whatever the number of threads.
 * `rows_done` is called now and then from the calling thread. */
struct map_result {
    std::vector<double> spectral_radius;
    long searches = 0; /* see dominant_root_finder */
};
map_result compute_map(const map_request &request, int threads, const std::function<void(int)> &rows_done = {});

/* A few pieces of rows of a map, with neighbours as near as on the whole of it: to time. */
map_request sample_of(const map_request &request);

} // namespace berth

#endif
