/* One thread pushes, another drains, on a disk that is full now and then: each record is in the file whole and in
 * order, or counted as dropped. */
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <doctest/doctest.h>
#include <thread>

#include "../../hal/linux/log_writer.h"
#include "../../hal/log_blocks.h"
#include "../../hal/log_file.h"
#include "../../sim_hal/hil/random.h"
#include "../support/files.h"
#include "../support/seed.h"

namespace
{
std::atomic<int> syncs{0};
}

/* In the place of the C library's. */
extern "C" int fdatasync(int file)
{
    syncs++;
    return static_cast<int>(syscall(SYS_fdatasync, file));
}

namespace berth
{

namespace
{

/* Disk full from here on. */
void limit_files_to(rlim_t bytes)
{
    rlimit limit{};
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
}

std::string record_of(std::uint32_t number, std::size_t extra_bytes)
{
    std::string record(9 + extra_bytes, static_cast<char>('a' + number % 26));
    const auto content = static_cast<std::uint16_t>(record.size() - 3);
    std::memcpy(&record[0], &content, 2);
    record[2] = 'D';
    std::memcpy(&record[3], "\0\0", 2);
    std::memcpy(&record[5], &number, 4);
    return record;
}

struct found_records {
    std::uint64_t count = 0;
    bool are_whole_and_in_order = true;
};

found_records records_in(const std::string &file)
{
    found_records found;
    std::int64_t newest = -1;
    std::size_t place = 16;
    while (place + 3 <= file.size()) {
        std::uint16_t content = 0;
        std::memcpy(&content, &file[place], 2);
        const std::string message = file.substr(place, 3u + content);
        if (message.size() >= 9 && message[2] == 'D') {
            std::uint32_t number = 0;
            std::memcpy(&number, &message[5], 4);
            found.are_whole_and_in_order &=
                message == record_of(number, message.size() - 9) && std::int64_t{number} > newest;
            newest = number;
            found.count++;
        }
        place += 3u + content;
    }
    found.are_whole_and_in_order &= place == file.size();
    return found;
}

} // namespace

TEST_CASE("log: two threads and a disk that fills up: every record is in the file or counted")
{
    REPRODUCIBLE();
    std::signal(SIGXFSZ, SIG_IGN);
    const temporary_folder folder;
    const std::string path = folder / "log.ulg";
    constexpr int rounds = 4000;
    std::atomic<std::uint32_t> pushes{0};
    std::uint64_t dropped = 0;
    {
        log_file log(path, {{}, {{0, "numbered", "numbered:uint32_t number;"}}}, 1 << 14);
        std::atomic<int> round{0};
        std::thread drainer([&] {
            for (std::uint32_t seen = 0; round < rounds; seen = pushes) {
                while (pushes == seen) {
                    std::this_thread::yield();
                }
                limit_files_to(++round % 4 == 0 ? 1000 : RLIM_INFINITY);
                log.drain();
            }
            limit_files_to(RLIM_INFINITY);
        });
        random_stream random(test_seed(), 3);
        for (; round < rounds; pushes++) {
            const std::string record = record_of(pushes, static_cast<std::size_t>(300.0 * random.uniform()));
            if (!log.push(record.data(), record.size())) {
                std::this_thread::yield();
            }
        }
        drainer.join();
        log.drain();
        dropped = log.dropped_records();
    }
    const found_records found = records_in(read_bytes(path));
    CHECK(found.are_whole_and_in_order);
    CHECK(found.count > rounds / 4);
    CHECK(dropped > 0);
    CHECK(found.count + dropped == pushes.load());
}

TEST_CASE("log: a second after it was pushed a record is on the disk, in a block with its checksum")
{
    const temporary_folder folder;
    const std::string path = folder / "log.ulg";
    cpu_set_t cpus;
    sched_getaffinity(0, sizeof cpus, &cpus);
    log_writer log(path, {{}, {{0, "numbered", "numbered:uint32_t number;"}}}, cpus);
    const std::string record = record_of(1, 100);
    const int before = syncs;
    REQUIRE(log.push(record.data(), record.size()));
    for (int waited_ms = 0; syncs == before && waited_ms < 20000; waited_ms += 10) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    CHECK(syncs > before);
    const std::string file = read_bytes(path);
    const log_check check = check_blocks(file);
    CHECK(records_in(file).count == 1);
    CHECK(check.whole_byte == file.size());
    CHECK_FALSE(check.is_ended);
    log.finish();
}

} // namespace berth
