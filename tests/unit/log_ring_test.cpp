#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <thread>
#include <vector>

#include "hal/log_ring.h"
#include "seeded.h"

namespace
{

struct ring_bench {
    std::vector<std::uint8_t> storage;
    log_ring ring{};

    explicit ring_bench(std::size_t capacity_bytes) : storage(capacity_bytes)
    {
        log_ring_start(&ring, storage.data(), capacity_bytes);
    }

    bool push(const std::vector<std::uint8_t> &record)
    {
        return log_ring_push(&ring, record.data(), record.size()) != 0;
    }

    /* All bytes waiting, in as many pieces as the ring hands them out. */
    std::vector<std::uint8_t> take_all()
    {
        std::vector<std::uint8_t> taken;
        const std::uint8_t *bytes = nullptr;
        while (const std::size_t size_bytes = log_ring_peek(&ring, &bytes)) {
            taken.insert(taken.end(), bytes, bytes + size_bytes);
            log_ring_take(&ring, size_bytes);
        }
        return taken;
    }
};

std::vector<std::uint8_t> counted_bytes(std::size_t size_bytes, std::uint8_t first)
{
    std::vector<std::uint8_t> bytes(size_bytes);
    for (std::size_t i = 0; i < size_bytes; i++) {
        bytes[i] = static_cast<std::uint8_t>(first + i);
    }
    return bytes;
}

} // namespace

TEST_CASE("log_ring: starts empty, gives back what was put in, in order")
{
    ring_bench bench(64);
    CHECK(log_ring_fill(&bench.ring) == 0);
    CHECK(bench.take_all().empty());
    CHECK(bench.push({1, 2, 3}));
    CHECK(bench.push({4, 5}));
    CHECK(log_ring_fill(&bench.ring) == 5);
    CHECK(bench.take_all() == std::vector<std::uint8_t>{1, 2, 3, 4, 5});
    CHECK(log_ring_fill(&bench.ring) == 0);
}

TEST_CASE("log_ring: a record that does not fit is refused whole and leaves the rest as it was")
{
    ring_bench bench(16);
    CHECK(bench.push(counted_bytes(10, 0)));
    CHECK_FALSE(bench.push(counted_bytes(7, 100)));
    CHECK(log_ring_fill(&bench.ring) == 10);
    CHECK(bench.push(counted_bytes(6, 10))); /* to the last byte */
    CHECK_FALSE(bench.push({99}));

    CHECK(bench.take_all() == counted_bytes(16, 0));
    CHECK_FALSE(bench.push(counted_bytes(17, 0)));
    CHECK(bench.take_all().empty());
}

TEST_CASE("log_ring: a record across the end of the storage comes out in two pieces and whole")
{
    ring_bench bench(16);
    CHECK(bench.push(counted_bytes(12, 0)));
    bench.take_all();
    CHECK(bench.push(counted_bytes(10, 50)));
    const std::uint8_t *bytes = nullptr;
    CHECK(log_ring_peek(&bench.ring, &bytes) == 4);
    CHECK(bytes == bench.storage.data() + 12);
    CHECK(bench.take_all() == counted_bytes(10, 50));
}

TEST_CASE("log_ring: totals may run over the end of their type")
{
    ring_bench bench(16);
    bench.ring.written = bench.ring.taken = SIZE_MAX - 4;
    for (std::uint8_t i = 0; i < 5; i++) {
        CHECK(bench.push(counted_bytes(11, i)));
        CHECK_FALSE(bench.push(counted_bytes(6, 0)));
        CHECK(log_ring_fill(&bench.ring) == 11);
        CHECK(bench.take_all() == counted_bytes(11, i));
    }
}

TEST_CASE("log_ring: agrees with a queue of bytes over random pushes and takes")
{
    SEEDED(random, "log_ring:*");
    ring_bench bench(256);
    std::deque<std::uint8_t> model;
    std::uint8_t next = 0;
    int refused = 0;
    for (int i = 0; i < 20000; i++) {
        const std::vector<std::uint8_t> record = counted_bytes(1 + random() % 99, next);
        const bool fits = model.size() + record.size() <= 256;
        REQUIRE(bench.push(record) == fits);
        if (fits) {
            model.insert(model.end(), record.begin(), record.end());
            next = static_cast<std::uint8_t>(next + record.size());
        }
        refused += !fits;
        const std::uint8_t *bytes = nullptr;
        const std::size_t shown = log_ring_peek(&bench.ring, &bytes);
        const std::size_t taken = std::min<std::size_t>(shown, random() % 100);
        REQUIRE(std::equal(bytes, bytes + taken, model.begin()));
        log_ring_take(&bench.ring, taken);
        model.erase(model.begin(), model.begin() + static_cast<std::ptrdiff_t>(taken));
        REQUIRE(log_ring_fill(&bench.ring) == model.size());
    }
    CHECK(refused > 100);
}

TEST_CASE("log_ring: one thread writes, another reads, no byte is lost or torn")
{
    ring_bench bench(1024);
    constexpr std::size_t total_bytes = 2000000;
    std::thread writer([&] {
        std::uint8_t record[37];
        for (std::size_t sent = 0; sent + sizeof record <= total_bytes;) {
            for (std::size_t i = 0; i < sizeof record; i++) {
                record[i] = static_cast<std::uint8_t>((sent + i) % 251);
            }
            if (log_ring_push(&bench.ring, record, sizeof record)) {
                sent += sizeof record;
            } else {
                std::this_thread::yield();
            }
        }
    });
    constexpr std::size_t expected_bytes = total_bytes / 37 * 37;
    std::size_t read = 0, wrong = 0;
    while (read < expected_bytes) {
        const std::uint8_t *bytes = nullptr;
        const std::size_t size_bytes = log_ring_peek(&bench.ring, &bytes);
        for (std::size_t i = 0; i < size_bytes; i++) {
            wrong += bytes[i] != (read + i) % 251;
        }
        log_ring_take(&bench.ring, size_bytes);
        read += size_bytes;
        if (size_bytes == 0) {
            std::this_thread::yield();
        }
    }
    writer.join();
    CHECK(wrong == 0);
    CHECK(log_ring_fill(&bench.ring) == 0);
}
