#include "log_writer.h"

#include <algorithm>
#include <chrono>

#include "../rig/rig_file.h"
#include "thread.h"

namespace berth
{

namespace
{
/* At 400 Hz and 330 bytes a tick the ring bridges half a minute of a disk that does not answer. */
constexpr std::size_t ring_bytes = std::size_t{1} << 22;
constexpr std::chrono::milliseconds write_every{50};
constexpr std::chrono::seconds sync_every{1}; /* what a power cut may cost */

/* Before the new file takes the name. Throws rather than write over the log of an earlier run. */
const std::string &with_room(const std::string &path, const log_rotation &rotation)
{
    if (rotation.is_on() && !path.empty()) {
        if (!shelve_log(path)) {
            throw input_error(path +
                              ": the log of the run before cannot be renamed, so this run would write over it; "
                              "let the program write in its folder, or move the file away");
        }
        make_room(path, rotation);
    }
    return path;
}

} // namespace

log_writer::log_writer(const std::string &path, const log_header &header, const cpu_set_t &cpus,
                       const log_rotation &rotation, log_file::witness witness)
    : path_(path), header_(header), rotation_(path.empty() ? log_rotation{} : rotation),
      file_(with_room(path, rotation), header, ring_bytes)
{
    file_.show_to(std::move(witness));
    thread_ = start_thread("log", cpus, [this] { run(); });
}

log_writer::~log_writer()
{
    finish();
}

void log_writer::run()
{
    using clock = std::chrono::steady_clock;
    std::unique_lock<std::mutex> lock(mutex_);
    auto synced_at = clock::now();
    auto part_began = synced_at;
    if (!path_.empty()) {
        sync_folder_of(path_);
    }
    while (!is_finishing_) {
        finish_wanted_.wait_for(lock, write_every);
        file_.drain();
        const auto now = clock::now();
        if (now - synced_at >= sync_every) {
            file_.sync();
            synced_at = now;
        }
        if (rotation_.is_due(file_.file_bytes(), std::chrono::duration<double>(now - part_began).count())) {
            begin_part();
            part_began = now;
        }
    }
}

/* A part that cannot be begun ends the rotation: the file that is there goes on. */
void log_writer::begin_part()
{
    header_.infos.erase(std::remove_if(header_.infos.begin(), header_.infos.end(),
                                       [](const auto &info) { return info.first == log_part_key; }),
                        header_.infos.end());
    header_.infos.emplace_back(log_part_key, std::to_string(++part_));
    if (!shelve_log(path_)) {
        rotation_ = {};
        return;
    }
    make_room(path_, rotation_);
    if (!file_.begin_part(path_, header_)) {
        rotation_ = {};
    }
    sync_folder_of(path_);
}

void log_writer::finish()
{
    if (!thread_.joinable()) {
        return;
    }
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        is_finishing_ = true;
    }
    finish_wanted_.notify_one();
    thread_.join();
    file_.drain();
}

} // namespace berth
