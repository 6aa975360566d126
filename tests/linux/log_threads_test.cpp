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

cpu_set_t all_cpus()
{
    cpu_set_t cpus;
    sched_getaffinity(0, sizeof cpus, &cpus);
    return cpus;
}

const log_header numbered{{}, {{0, "numbered", "numbered:uint32_t number;"}}};

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
    log_writer log(path, numbered, all_cpus());
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
    CHECK(check.readable_bytes == file.size());
    CHECK(check.has_blocks);
    CHECK_FALSE(check.is_ended);
    CHECK_FALSE(check.damage);
    log.finish();
}

TEST_CASE("log: rotation by size and age: no record is lost between two files, and the oldest files go")
{
    constexpr std::uint32_t records = 300;
    constexpr std::size_t record_bytes = 1000;
    const struct {
        const char *name;
        log_rotation rotation;
        int files_min; /* the one that is written last included */
        int files_max;
    } cases[] = {
        {"no rotation", {0.0, 0.0, 0.0}, 1, 1},
        {"size", {0.05, 0.0, 0.0}, 3, 8},
        {"age", {0.0, 0.1 / 3600.0, 0.0}, 3, 1000},
        {"size, with a cap", {0.05, 0.0, 0.16}, 2, 3},
    };
    for (const auto &row : cases) {
        CAPTURE(row.name);
        const temporary_folder folder;
        std::ofstream(folder / "log.ulg") << "of an earlier run";
        std::ofstream(folder / "log.other.ulg") << "no log of ours";
        {
            log_writer log(folder / "log.ulg", numbered, all_cpus(), row.rotation);
            for (std::uint32_t number = 0; number < records; number++) {
                const std::string record = record_of(number, record_bytes - 9);
                REQUIRE(log.push(record.data(), record.size()));
                std::this_thread::sleep_for(std::chrono::milliseconds(4));
            }
            log.finish();
            CHECK(log.file().dropped_records() == 0);
        }
        std::string all(16, '\0');
        int files = 0;
        double bytes = 0.0;
        const auto add = [&](const std::string &name) {
            const std::string file = read_bytes(folder / name);
            if (file.size() > 16 && file.compare(0, 4, "ULog") == 0) {
                const log_check check = check_blocks(file);
                CHECK(check.is_ended);
                CHECK_FALSE(check.damage);
                CHECK((file.find(log_part_key) != std::string::npos) == (files > 0 || row.rotation.total_MB > 0.0));
                all += file.substr(16);
                files++;
            }
            bytes += static_cast<double>(file.size());
        };
        const bool is_rotated = row.rotation.is_on();
        CHECK(read_bytes(folder / "log.1.ulg") ==
              (is_rotated && row.rotation.total_MB == 0.0 ? "of an earlier run" : ""));
        for (int number = 2; number < 1100; number++) {
            add("log." + std::to_string(number) + ".ulg");
        }
        add("log.ulg");
        CHECK(files >= row.files_min);
        CHECK(files <= row.files_max);
        CHECK(read_bytes(folder / "log.other.ulg") == "no log of ours");
        const found_records found = records_in(all);
        CHECK(found.are_whole_and_in_order);
        if (row.rotation.total_MB > 0.0) {
            CHECK(bytes <= 1e6 * row.rotation.total_MB);
            CHECK(found.count < records);
        } else {
            CHECK(found.count == records);
        }
    }
}

} // namespace berth
