#include "candump.h"

#include <algorithm>
#include <cstdio>

#include "../../hal/rig/rig_file.h"
#include "ulog_reader.h"

namespace berth
{

namespace
{

const char *const bus_names[HAL_BUS_COUNT] = {"robot", "sensor"};

void append_line(std::string &text, const hal_frame &frame)
{
    char line[64];
    const auto us = static_cast<long long>(frame.time_ns / 1000);
    int size = std::snprintf(line, sizeof line, "(%010lld.%06lld) can%d ", us / 1000000, us % 1000000, frame.bus);
    if (frame.flags & HAL_FRAME_ERROR) {
        size += std::snprintf(line + size, sizeof line - static_cast<std::size_t>(size), "20000000#");
    } else {
        size += std::snprintf(line + size, sizeof line - static_cast<std::size_t>(size), "%03X#",
                              static_cast<unsigned>(frame.id));
    }
    if (frame.flags & HAL_FRAME_REMOTE) {
        size += std::snprintf(line + size, sizeof line - static_cast<std::size_t>(size), "R");
    }
    for (int i = 0; i < frame.length; i++) {
        size += std::snprintf(line + size, sizeof line - static_cast<std::size_t>(size), "%02X", frame.data[i]);
    }
    text.append(line, static_cast<std::size_t>(size));
    text += '\n';
}

void write_whole(const std::string &path, const std::string &text)
{
    const std::string partial = path + ".partial";
    std::FILE *file = std::fopen(partial.c_str(), "wb");
    bool is_written = file != nullptr && std::fwrite(text.data(), 1, text.size(), file) == text.size();
    is_written = (file != nullptr && std::fclose(file) == 0) && is_written;
    if (!is_written || std::rename(partial.c_str(), path.c_str()) != 0) {
        std::remove(partial.c_str());
        throw input_error(path + ": cannot be written; is the folder writable and the disk not full?");
    }
}

} // namespace

std::vector<std::string> candump_paths(const std::string &log_path)
{
    const std::size_t dot = log_path.rfind('.');
    const std::string stem = log_path.substr(0, dot > log_path.rfind('/') + 1 ? dot : std::string::npos);
    std::vector<std::string> paths;
    for (const char *const bus : bus_names) {
        paths.push_back(stem + "." + bus + ".candump.log");
    }
    return paths;
}

std::vector<std::string> export_candump(const std::string &log_path)
{
    std::vector<hal_frame> frames[HAL_BUS_COUNT];
    ulog_reader log(log_path);
    std::uint16_t id = 0;
    std::string_view bytes;
    while (log.next(id, bytes)) {
        if (id == ULOG_FRAME_ID) {
            const hal_frame frame = frame_of(record_as<frame_record>(bytes));
            if (frame.bus < HAL_BUS_COUNT) {
                frames[frame.bus].push_back(frame);
            }
        }
    }
    std::vector<std::string> paths = candump_paths(log_path);
    for (int bus = 0; bus < HAL_BUS_COUNT; bus++) {
        std::stable_sort(frames[bus].begin(), frames[bus].end(),
                         [](const hal_frame &a, const hal_frame &b) { return a.time_ns < b.time_ns; });
        std::string text;
        for (const hal_frame &frame : frames[bus]) {
            append_line(text, frame);
        }
        write_whole(paths[static_cast<std::size_t>(bus)], text);
    }
    return paths;
}

} // namespace berth
