/* The simulated operator: one command frame a tick, following the profile from the release on. Asks to run from then
 * on, and lets go and asks again where the loop was not ready yet. */
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

    std::uint8_t bus() const { return bus_; } /* enum hal_bus */

    /* Puts the frame that is due on the bus. */
    void send(can_bus &bus);

    /* Takes a frame of the loop: its status is what the operator sees. */
    void receive(const hal_frame &frame);

    /* Sends nothing while silent. */
    void set_silent(bool silent) { is_silent_ = silent; }

    /* Overrides the request that the station makes by its schedule (enum operator_request); negative: by schedule.
     */
    void set_request(int request) { request_override_ = request; }

  private:
    std::uint8_t scheduled_request(std::int64_t now_ns, bool is_released);
    hal_frame motion_frame(const profile_point &point, std::uint8_t request);
    hal_frame force_frame(const profile_point &point, std::uint8_t request);
    hal_frame order_frame(const arm_order &order);

    profile profile_;
    std::vector<operator_order> orders_;
    std::size_t next_order_ = 0;
    std::uint8_t joint_counter_ = 0;
    std::uint8_t line_counter_ = 0;
    std::int32_t interface_;
    std::uint8_t bus_;
    double release_s_;
    std::int64_t period_ns_;
    std::int64_t next_frame_ns_ = 0;
    std::uint8_t counter_ = 0;
    bool is_silent_ = false;
    int request_override_ = -1;
    bool loop_is_ready_ = false;       /* says its newest status */
    std::int64_t asked_since_ns_ = -1; /* to run, without letting go; negative: not yet */
};

} // namespace berth

#endif
