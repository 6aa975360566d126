#include "rig_log.h"

#include "../../firmware/recorder.h"
#include "../version.h"
#include "given.h"
#include "rig_file.h"

namespace berth
{

log_header rig_log_header(const rig &rig)
{
    log_header header = {
        {{"sys_name", "berth"},
         {"ver_sw", version()},
         {"berth_config_hash", config_hash(rig)},
         {"berth_config", print_rig(rig)},
         {"berth_assumed", assumed_text(rig)}},
        {{ULOG_TICK_ID, "tick", tick_record_format}, {ULOG_FRAME_ID, "can_frame", frame_record_format}}};
    if (rig.firmware.arm.kind != ARM_NONE) {
        header.topics.push_back({ULOG_ARM_ID, "arm", arm_record_format});
    }
    if (rig.has_side_axes()) {
        header.topics.push_back({ULOG_SIDE_ID, "side", side_record_format});
    }
    return header;
}

} // namespace berth
