/* A loop with profile "cia402" and a drive made of nothing but bytes written down from CiA 301 and 402. */
#ifndef TESTS_UNIT_DRIVE_BENCH_H
#define TESTS_UNIT_DRIVE_BENCH_H

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "firmware/app.h"
#include "tick_builder.h"

namespace bench
{

constexpr std::uint8_t node = 5;
constexpr std::uint8_t master = 99;
constexpr double counts_per_m = 1e7;

inline app_config drive_config()
{
    app_config config = moving_config();
    config.robot_channel.profile = ROBOT_PROFILE_CIA402;
    config.cia402.node_id = node;
    config.cia402.master_node_id = master;
    config.cia402.counts_per_m = counts_per_m;
    REQUIRE(config_validate(&config).key == nullptr);
    return config;
}

using bytes = std::vector<std::uint8_t>;

inline hal_frame frame_with(std::uint32_t id, const bytes &data)
{
    hal_frame frame = frame_of(id, HAL_BUS_ROBOT, 0);
    frame.length = static_cast<std::uint8_t>(data.size());
    std::copy(data.begin(), data.end(), frame.data);
    return frame;
}

/* A loop and a drive that does as it is told, at once; each part of it can be made to fail. */
class drive_bench
{
  public:
    explicit drive_bench(const app_config &config = drive_config())
        : app_(std::make_unique<struct app>()), period_ns_(config_period_ns(&config))
    {
        app_start(app_.get(), &config);
    }

    void tick()
    {
        const std::int64_t now_ns = index_ * period_ns_;
        tick_input in{};
        in.tick = {index_, now_ns, now_ns, 0, stop};
        in.enable = enable;
        in.emergency_stop = emergency_stop;
        const auto counter = static_cast<std::uint8_t>(index_);
        in.frames[in.frame_count++] = force_frame(0.0, counter, now_ns);
        in.frames[in.frame_count++] = motion_frame(0.0, 0.0, operator_.asks(request, state()), counter, now_ns);
        if (heartbeats && index_ * period_ns_ % 100000000 < period_ns_) {
            answers.push_back(frame_with(0x700 + node, {nmt}));
        }
        for (hal_frame &frame : answers) {
            frame.time_ns = now_ns;
            if (in.frame_count < TICK_FRAMES_IN_MAX) {
                in.frames[in.frame_count++] = frame;
            }
        }
        answers.clear();
        out = {};
        app_step(app_.get(), &in, &out);
        for (std::uint32_t i = 0; i < out.frame_count; i++) {
            hear(out.frames[i]);
        }
        index_++;
    }

    void run(int ticks)
    {
        for (int i = 0; i < ticks; i++) {
            tick();
        }
    }

    bool run_until(supervisor_state wanted, int ticks_max = 2000)
    {
        for (int i = 0; i < ticks_max && state() != wanted; i++) {
            tick();
        }
        return state() == wanted;
    }

    const hal_frame *sent(std::uint32_t id) const
    {
        for (std::uint32_t i = 0; i < out.frame_count; i++) {
            if (out.frames[i].id == id) {
                return &out.frames[i];
            }
        }
        return nullptr;
    }

    /* After trouble: a fault lasts until the reset, and from there the loop runs again. */
    void check_reset_brings_back()
    {
        run(500);
        CHECK(state() == SUPERVISOR_FAULT);
        request = OPERATOR_RESET;
        REQUIRE(run_until(SUPERVISOR_READY));
        request = OPERATOR_RUN;
        CHECK(run_until(SUPERVISOR_RUNNING));
    }

    std::uint16_t sent_controlword() const
    {
        const hal_frame *frame = sent(0x200 + node);
        REQUIRE(frame != nullptr);
        return static_cast<std::uint16_t>(frame->data[0] | frame->data[1] << 8);
    }

    supervisor_state state() const { return app_->supervisor.state; }
    stop_cause cause() const { return app_->supervisor.stop_cause; }
    const struct app &app() const { return *app_; }
    int trouble() const { return app_->robot_channel.drive.trouble; }

    patient_operator operator_;
    int request = OPERATOR_RUN;
    std::uint8_t enable = HAL_LEVEL_NOT_WIRED, emergency_stop = 0;
    std::uint32_t stop = 0;
    bool answers_polls = true, toggles = true;
    std::vector<std::int64_t> polls; /* ticks at which the loop has asked for the state */
    std::int32_t position = 100000;  /* in counts: where it was sent, once it is enabled */
    std::uint16_t homing_bits = 0;   /* of the statusword, beside the state */
    bool heartbeats = true, boots = true, answers_sdo = true, sends_pdos = true, enables = true;
    std::uint8_t nmt = 0x7f;
    std::uint16_t statusword = 0x0250;   /* switch on disabled */
    std::map<int, bytes> answer_instead; /* by object * 256 + subindex: to a write, or a read of nothing but it */
    std::set<std::int8_t> indices;       /* of 0x60C2 that it takes; empty: all */
    int fixed_period = 0;                /* 0x60C2:01, if it cannot be written */
    std::int8_t period_index = -3;
    std::uint8_t period_value = 1;
    /* First byte of the answer to a read: 0 as it should be; 0x41 and 0x40: in a segment. */
    std::uint8_t read_command = 0;
    std::uint8_t write_command = 0x60;
    std::vector<bytes> requests;    /* all SDO requests */
    std::vector<hal_frame> answers; /* of the drive, for the next tick */
    tick_output out{};

  private:
    void hear(const hal_frame &frame)
    {
        if (frame.id == 0x000 && frame.data[1] == node) {
            if (frame.data[0] == 0x82 && boots) {
                nmt = 0x7f;
                toggle_ = 0;
                answers.push_back(frame_with(0x700 + node, {0x00}));
            } else if (frame.data[0] == 0x01) {
                nmt = 0x05;
                if (heartbeats) {
                    answers.push_back(frame_with(0x700 + node, {nmt}));
                }
            }
        } else if (frame.id == 0x700 + node && (frame.flags & HAL_FRAME_REMOTE) != 0) {
            polls.push_back(index_);
            if (answers_polls) {
                answers.push_back(frame_with(0x700 + node, {static_cast<std::uint8_t>(nmt | toggle_)}));
            }
            toggle_ ^= toggles ? 0x80 : 0;
        } else if (frame.id == 0x600 + node) {
            requests.emplace_back(frame.data, frame.data + 8);
            if (answers_sdo && frame.data[0] != 0x80) {
                answers.push_back(
                    frame_with(0x580 + node, frame.data[0] == 0x60 ? segment_ : answer_to(requests.back())));
            }
        } else if (frame.id == 0x200 + node) {
            waiting_ = static_cast<std::uint16_t>(frame.data[0] | frame.data[1] << 8);
            std::memcpy(&target_, frame.data + 2, 4);
        } else if (frame.id == 0x080 && nmt == 0x05 && sends_pdos) {
            obey(waiting_);
            position = statusword == 0x1237 ? target_ : position;
            bytes data(6);
            std::memcpy(data.data(), &statusword, 2);
            std::memcpy(data.data() + 2, &position, 4);
            answers.push_back(frame_with(0x180 + node, data));
        }
    }

    /* Value and size of the object. */
    std::pair<std::uint32_t, int> read(int key) const
    {
        switch (key) {
        case 0x100000:
            return {0x00020192, 4};
        case 0x650200:
            return {0x80, 4};
        case 0x604100:
            return {statusword | homing_bits, 2};
        case 0x60c201:
            return {fixed_period != 0 ? static_cast<std::uint8_t>(fixed_period) : period_value, 1};
        case 0x60c202:
            return {static_cast<std::uint8_t>(period_index), 1};
        default:
            return {8, 1};
        }
    }

    bytes answer_to(const bytes &asked)
    {
        const int object = asked[1] | asked[2] << 8;
        const int key = object << 8 | asked[3];
        bytes answer = {write_command, asked[1], asked[2], asked[3], 0, 0, 0, 0};
        if (const auto instead = answer_instead.find(key); instead != answer_instead.end()) {
            return instead->second;
        }
        if (asked[0] == 0x40) {
            const auto [value, size] = read(key);
            answer[0] = read_command != 0 ? read_command : static_cast<std::uint8_t>(0x43 | (4 - size) << 2);
            std::memcpy(answer.data() + 4, &value, 4);
            segment_ = {static_cast<std::uint8_t>(0x01 | (7 - size) << 1), 0, 0, 0, 0, 0, 0, 0};
            std::memcpy(segment_.data() + 1, &value, 4);
            if ((read_command & 0x02) == 0 && read_command != 0) { /* the size alone */
                const auto told = static_cast<std::uint32_t>(size);
                std::memcpy(answer.data() + 4, &told, 4);
            }
            return answer;
        }
        if (key == 0x604000) {
            obey(static_cast<std::uint16_t>(asked[4] | asked[5] << 8));
        }
        const auto index = static_cast<std::int8_t>(asked[4]);
        const bool is_refused = (key == 0x60c202 && !indices.empty() && indices.count(index) == 0) ||
                                (key == 0x60c201 && fixed_period != 0 && asked[4] != fixed_period);
        if (is_refused) {
            return {0x80, asked[1], asked[2], asked[3], 0x30, 0x00, 0x09, 0x06};
        }
        period_index = key == 0x60c202 ? index : period_index;
        period_value = key == 0x60c201 ? asked[4] : period_value;
        return answer;
    }

    void obey(std::uint16_t controlword)
    {
        const bool is_fault = (statusword & 0x4f) == 0x08;
        if (is_fault) {
            statusword = (controlword & 0x80) != 0 ? 0x0250 : statusword;
        } else if ((controlword & 0x02) == 0) {
            statusword = 0x0250;
        } else if ((controlword & 0x0f) == 0x06) {
            statusword = 0x0231;
        } else if ((controlword & 0x0f) == 0x07 && statusword != 0x0250) {
            statusword = 0x0233;
        } else if ((controlword & 0x0f) == 0x0f && (statusword == 0x0233 || statusword == 0x1237) && enables) {
            statusword = 0x1237;
        }
    }

    std::unique_ptr<struct app> app_;
    std::int64_t period_ns_;
    bytes segment_; /* the value that was asked for */
    std::int64_t index_ = 0;
    std::uint8_t toggle_ = 0;
    std::int32_t target_ = 0;
    std::uint16_t waiting_ = 0;
};

inline bytes sdo(std::uint8_t command, int object, std::uint8_t subindex, std::uint32_t value)
{
    return {command,
            static_cast<std::uint8_t>(object),
            static_cast<std::uint8_t>(object >> 8),
            subindex,
            static_cast<std::uint8_t>(value),
            static_cast<std::uint8_t>(value >> 8),
            static_cast<std::uint8_t>(value >> 16),
            static_cast<std::uint8_t>(value >> 24)};
}

} // namespace bench

#endif
