#include <doctest/doctest.h>

#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/recorder.h"
#include "tick_builder.h"

namespace
{

struct field {
    std::string type;
    std::size_t offset_bytes;
};

struct layout {
    std::string name;
    std::map<std::string, field> fields;
    std::size_t size_bytes = 0;
};

/* Reads "name:type field;type field;..." the way a ULog reader does: no padding but what is written down. */
layout layout_of(const char *format)
{
    static const std::map<std::string, std::size_t> sizes = {{"uint8_t", 1},  {"uint16_t", 2}, {"uint32_t", 4},
                                                             {"uint64_t", 8}, {"int64_t", 8},  {"double", 8},
                                                             {"float", 4}};
    layout layout;
    std::istringstream text(format);
    std::getline(text, layout.name, ':');
    std::string entry;
    while (std::getline(text, entry, ';')) {
        std::istringstream words(entry);
        std::string type, name;
        words >> type >> name;
        REQUIRE(sizes.count(type) == 1);
        REQUIRE(layout.fields.count(name) == 0);
        layout.fields[name] = {type, layout.size_bytes};
        layout.size_bytes += sizes.at(type);
    }
    return layout;
}

struct message {
    std::uint16_t id = 0;
    std::vector<std::uint8_t> content;

    template <class T>
    T get(const layout &layout, const std::string &name) const
    {
        T value{};
        const std::size_t at = layout.fields.at(name).offset_bytes;
        REQUIRE(at + sizeof value <= content.size());
        std::memcpy(&value, content.data() + at, sizeof value);
        return value;
    }
};

/* Splits ULog bytes: u16 size of what follows the type, u8 type, and in a data message u16 id. */
std::vector<message> messages_of(const recorder &recorder)
{
    std::vector<message> messages;
    std::size_t at = 0;
    while (at < recorder.size_bytes) {
        REQUIRE(at + 5 <= recorder.size_bytes);
        const std::size_t size_bytes = recorder.bytes[at] | recorder.bytes[at + 1] << 8;
        REQUIRE(recorder.bytes[at + 2] == 'D');
        REQUIRE(at + 3 + size_bytes <= recorder.size_bytes);
        message message;
        message.id = static_cast<std::uint16_t>(recorder.bytes[at + 3] | recorder.bytes[at + 4] << 8);
        message.content.assign(recorder.bytes + at + 5, recorder.bytes + at + 3 + size_bytes);
        messages.push_back(message);
        at += 3 + size_bytes;
    }
    CHECK(at == recorder.size_bytes);
    return messages;
}

} // namespace

TEST_CASE("recorder: the formats describe the records to the byte, units last")
{
    const layout tick = layout_of(tick_record_format);
    CHECK(tick.name == "tick");
    CHECK(tick.size_bytes == sizeof(tick_record));
    CHECK(tick.fields.at("timestamp").offset_bytes == 0);
    CHECK(tick.fields.at("timestamp").type == "uint64_t");
    CHECK(tick.fields.at("command_position_m").offset_bytes == offsetof(tick_record, command_position_m));
    CHECK(tick.fields.at("heartbeat").offset_bytes == offsetof(tick_record, heartbeat));

    const layout frame = layout_of(frame_record_format);
    CHECK(frame.name == "can_frame");
    CHECK(frame.size_bytes == sizeof(frame_record));
    CHECK(frame.fields.at("direction").offset_bytes == offsetof(frame_record, direction));

    for (const auto &entry : tick.fields) {
        const std::string &name = entry.first;
        CAPTURE(name);
        if (entry.second.type == "double" ||
            entry.second.type == "float") { /* every physical quantity says its unit */
            static const std::set<std::string> units = {"_m", "_m_per_s", "_N", "_J", "_kg", "_s", "_ms", "_s2"};
            static const std::set<std::string> pure_numbers = {"inverse_gain"};
            const std::string unit =
                name.substr(name.rfind("_m_per_s") != std::string::npos ? name.rfind("_m_per_s") : name.rfind('_'));
            const bool has_unit = units.count(unit) == 1 || pure_numbers.count(name) == 1;
            CHECK(has_unit);
        }
    }
}

TEST_CASE("recorder: a tick is its received frames, its sent frames, then itself")
{
    tick_input in{};
    in.frame_count = 2;
    in.frames[0] = bench::feedback_frame(0.25, 17, 1111);
    in.frames[1] = bench::force_frame(-3.0, 18, 2222);
    in.frames[1].flags = HAL_FRAME_ERROR;
    tick_output out{};
    out.frame_count = 1;
    out.frames[0] = bench::frame_of(0x10, HAL_BUS_ROBOT, 3333);
    out.frames[0].data[0] = 0xab;
    out.frames[0].data[7] = 0xcd;
    recorder recorder{};
    tick_record &record = recorder.tick;
    record.timestamp = 12345;
    record.index = -7;
    record.force_N = 1.0 / 3.0;
    record.conditions = 0x20304;
    record.stop_cause = STOP_BUS_OFF;

    recorder_write(&recorder, &in, &out, nullptr, nullptr);
    const std::vector<message> messages = messages_of(recorder);
    const layout frame = layout_of(frame_record_format), tick = layout_of(tick_record_format);
    REQUIRE(messages.size() == 4);
    const hal_frame *frames[] = {&in.frames[0], &in.frames[1], &out.frames[0]};
    for (int i = 0; i < 3; i++) {
        CAPTURE(i);
        const message &written = messages[static_cast<std::size_t>(i)];
        CHECK(written.id == ULOG_FRAME_ID);
        CHECK(written.content.size() == frame.size_bytes);
        CHECK(written.get<std::uint64_t>(frame, "timestamp") == 12345);
        CHECK(written.get<std::int64_t>(frame, "time_ns") == frames[i]->time_ns);
        CHECK(written.get<std::uint32_t>(frame, "id") == frames[i]->id);
        CHECK(written.get<std::uint8_t>(frame, "bus") == frames[i]->bus);
        CHECK(written.get<std::uint8_t>(frame, "length") == 8);
        CHECK(written.get<std::uint8_t>(frame, "flags") == frames[i]->flags);
        CHECK(written.get<std::uint8_t>(frame, "direction") == (i == 2));
        const std::size_t data_at = frame.fields.at("data").offset_bytes;
        CHECK(std::memcmp(written.content.data() + data_at, frames[i]->data, 8) == 0);
    }
    CHECK(messages[3].id == ULOG_TICK_ID);
    CHECK(messages[3].content.size() == tick.size_bytes);
    CHECK(messages[3].get<std::int64_t>(tick, "index") == -7);
    CHECK(messages[3].get<double>(tick, "force_N") == 1.0 / 3.0);
    CHECK(messages[3].get<std::uint32_t>(tick, "conditions") == 0x20304);
    CHECK(messages[3].get<std::uint8_t>(tick, "stop_cause") == STOP_BUS_OFF);
}

TEST_CASE("recorder: the fullest tick fits, and a tick replaces the one before")
{
    tick_input in{};
    tick_output out{};
    const arm_record arm{};
    const side_record side{};
    recorder recorder{};
    in.frame_count = TICK_FRAMES_IN_MAX;
    out.frame_count = TICK_FRAMES_OUT_MAX;
    recorder_write(&recorder, &in, &out, &arm, &side);
    CHECK(recorder.size_bytes == RECORDER_TICK_BYTES_MAX);
    CHECK(messages_of(recorder).size() == TICK_FRAMES_IN_MAX + TICK_FRAMES_OUT_MAX + 3);
    in.frame_count = out.frame_count = 0;
    recorder_write(&recorder, &in, &out, nullptr, nullptr);
    CHECK(recorder.size_bytes == 5 + sizeof(tick_record));
    CHECK(messages_of(recorder).size() == 1);
}

TEST_CASE("recorder: what app_step records is what went in and came out")
{
    bench::app_bench bench;
    bench.force_N = 2.5;
    bench.operator_position_m = 0.005;
    bench.request = OPERATOR_RUN;
    bench.robot_position_m = 0.0105; /* beside the setpoint, within the start tolerance */
    bench.has_robot = false;
    bench.missed = 1;
    bench.run(3);
    const layout tick = layout_of(tick_record_format);
    const std::vector<message> messages = messages_of(bench.app().recorder);
    REQUIRE(messages.size() == 3 + bench.out().frame_count + 1);
    const message &last = messages.back();
    CHECK(last.get<std::int64_t>(tick, "index") == 2);
    CHECK(last.get<std::int64_t>(tick, "scheduled_ns") == 5000000);
    CHECK(last.get<std::uint64_t>(tick, "timestamp") == 5000);
    CHECK(last.get<std::int64_t>(tick, "force_frame_age_ns") == 0);
    CHECK(last.get<double>(tick, "force_N") == doctest::Approx(2.5));
    CHECK(last.get<double>(tick, "operator_position_m") == doctest::Approx(0.005));
    CHECK(last.get<double>(tick, "robot_position_m") == doctest::Approx(0.0105));
    CHECK(last.get<std::uint32_t>(tick, "missed_ticks") == 1);
    CHECK(last.get<std::uint8_t>(tick, "enable") == 1);
    CHECK(last.get<std::uint8_t>(tick, "operator_request") == OPERATOR_RUN);
    CHECK(last.get<std::uint8_t>(tick, "state") == SUPERVISOR_READY); /* the request was on from the start */
    CHECK(last.get<std::uint8_t>(tick, "heartbeat") == bench.out().heartbeat);
}
