/* Every reader of a file that somebody else wrote, for libFuzzer: whatever the bytes are, it ends with a result or
 * with input_error. scripts/fuzz.py runs it.
 *
 *   parsers --parser=NAME [libFuzzer's options and corpora] */
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "../../hal/rig/arm_file.h"
#include "../../hal/rig/commissioning.h"
#include "../../hal/rig/rig_file.h"
#include "../../hal/rig/robot_file.h"
#include "../../sim_hal/arm/urdf.h"
#include "../../sim_hal/diagnosis/record/record.h"
#include "../../sim_hal/hil/profile.h"
#include "../../sim_hal/hil/wake_histogram.h"
#include "../../sim_hal/log/ulog_reader.h"
#include "../../sim_hal/rths/building.h"

namespace
{

using berth::rig;

/* For readers of files: these bytes at a path. */
class file_in_memory
{
  public:
    explicit file_in_memory(const std::string &bytes) : file_(memfd_create("input", 0))
    {
        std::size_t written = 0;
        while (file_ >= 0 && written < bytes.size()) {
            const ssize_t more = ::write(file_, bytes.data() + written, bytes.size() - written);
            if (more <= 0) {
                break;
            }
            written += static_cast<std::size_t>(more);
        }
        if (file_ < 0 || written < bytes.size()) {
            std::perror("memfd_create");
            std::abort();
        }
    }
    ~file_in_memory() { close(file_); }
    file_in_memory(const file_in_memory &) = delete;
    file_in_memory &operator=(const file_in_memory &) = delete;

    std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

  private:
    int file_;
};

/* A rig as it is printed is the same rig. */
void read_rig(const std::string &bytes)
{
    const rig read = berth::parse_rig(bytes, "rig");
    const std::string printed = berth::print_rig(read);
    if (berth::print_rig(berth::parse_rig(printed, "printed")) != printed) {
        std::abort();
    }
}

void read_robot(const std::string &bytes)
{
    berth::parse_robot(bytes, "robot");
}

void read_arm(const std::string &bytes)
{
    const std::string printed = berth::print_arm(berth::parse_arm(bytes, "arm"));
    if (berth::print_arm(berth::parse_arm(printed, "printed")) != printed) {
        std::abort();
    }
}

void read_urdf(const std::string &bytes)
{
    berth::arm_from_urdf(bytes, "urdf", {});
}

void read_commissioning(const std::string &bytes)
{
    berth::parse_commissioning(bytes, "commissioning");
}

void read_histogram(const std::string &bytes)
{
    berth::parse_wake_histogram(bytes, "histogram");
}

void read_log(const std::string &bytes)
{
    berth::ulog_reader log(file_in_memory(bytes).path());
    log.recorded_rig();
    std::uint16_t id = 0;
    for (std::string_view record; log.next(id, record);) {
    }
}

void read_record(const std::string &bytes)
{
    static const rig rig = berth::load_rig("ess");
    berth::read_record(file_in_memory(bytes).path(), rig);
}

void read_profile(const std::string &bytes)
{
    berth::read_csv_columns(file_in_memory(bytes).path(), {"", "m", 1.0, "profile.column", "profile.scale"});
}

void read_building(const std::string &bytes)
{
    const file_in_memory file(bytes);
    berth::rths::read_building(file.path());
}

void read_earthquake(const std::string &bytes)
{
    const file_in_memory file(bytes);
    const berth::rths::ground_motion motion(file.path(), 1.0);
    motion.at(motion.end_s());
}

constexpr struct {
    std::string_view name;
    void (*read)(const std::string &bytes);
} parsers[] = {
    {"rig", read_rig},
    {"robot", read_robot},
    {"arm", read_arm},
    {"urdf", read_urdf},
    {"commissioning", read_commissioning},
    {"histogram", read_histogram},
    {"log", read_log},
    {"record", read_record},
    {"profile", read_profile},
    {"building", read_building},
    {"earthquake", read_earthquake},
};

void (*chosen)(const std::string &bytes);

} // namespace

extern "C" int LLVMFuzzerInitialize(int *count, char ***words)
{
    constexpr std::string_view option = "--parser=";
    for (int i = 1; i < *count; i++) {
        const std::string_view word = (*words)[i];
        for (const auto &parser : parsers) {
            if (word.substr(0, option.size()) == option && word.substr(option.size()) == parser.name) {
                chosen = parser.read;
            }
        }
    }
    if (chosen == nullptr) {
        std::fprintf(stderr, "usage: parsers --parser=NAME [libFuzzer's options and corpora]\nNAME:");
        for (const auto &parser : parsers) {
            std::fprintf(stderr, " %s", std::string(parser.name).c_str());
        }
        std::fprintf(stderr, "\n");
        std::exit(2);
    }
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size)
{
    try {
        chosen(std::string(reinterpret_cast<const char *>(data), size));
    } catch (const berth::input_error &) { // told to the user, who mends the file
    }
    return 0;
}
