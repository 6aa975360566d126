/* The simulated operator: one command frame a tick, following the profile from the release on. */
#ifndef SIM_HAL_HIL_OPERATOR_STATION_H
#define SIM_HAL_HIL_OPERATOR_STATION_H

#include "../../hal/rig/rig.h"
#include "can_bus.h"
#include "profile.h"

namespace berth
{

class operator_station
{
  public:
    explicit operator_station(const rig &rig);

    std::int64_t next_frame_ns() const { return next_frame_ns_; }

    /* Puts the frame that is due on the bus. */
    void send(can_bus &bus);

    /* Sends nothing while silent. */
    void set_silent(bool silent) { is_silent_ = silent; }

    /* Overrides the request that the station makes by its schedule (enum operator_request); negative: by schedule.
     */
    void set_request(int request) { request_override_ = request; }

  private:
    hal_frame motion_frame(const profile_point &point, std::uint8_t request);
    hal_frame force_frame(const profile_point &point, std::uint8_t request);
    hal_frame order_frame(const arm_order &order);

    profile profile_;
    std::vector<operator_order> orders_;
    std::size_t next_order_ = 0;
    std::uint8_t joint_counter_ = 0;
    std::uint8_t line_counter_ = 0;
    std::int32_t interface_;
    double release_s_;
    std::int64_t period_ns_;
    std::int64_t next_frame_ns_ = 0;
    std::uint8_t counter_ = 0;
    bool is_silent_ = false;
    int request_override_ = -1;
};

} // namespace berth

#endif
