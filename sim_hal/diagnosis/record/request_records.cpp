#include "request_records.h"

#include <cstdio>
#include <tuple>

#include "../../../hal/rig/rig_file.h"
#include "independent_records.h"
#include "measured_motion.h"
#include "mistaken_signals.h"
#include "record_table.h"
#include "sample_age.h"
#include "side_records.h"

namespace berth
{

namespace
{

/* A rig that was given no rate gets the record's. */
void take_rate(rig &rig, record &data)
{
    if (rig.is_rate_given) {
        return;
    }
    rig.firmware.loop.rate_Hz = 1.0 / data.period_s;
    rig.is_rate_given = true;
    const bool shows_robot =
        !data.command_position_m.empty() && !(data.robot_position_m.empty() && data.force_N.empty());
    const bool must_hold = !shows_robot && rig.robot.interpolation == interpolation::linear &&
                           1e-3 * rig.robot.dead_time_ms < data.period_s;
    if (must_hold) {
        rig.robot.interpolation = interpolation::hold;
    }
    char rate[40];
    std::snprintf(rate, sizeof rate, "loop.rate_Hz = %.10g", rig.firmware.loop.rate_Hz);
    if (const auto error = complete_and_check(rig)) {
        throw input_error(data.path + ": the rig file states no loop.rate_Hz, and with the record's, " + rate +
                          ", " + error->key + " " + error->message);
    }
    data.notes.push_back(std::string(rate) + " is the record's: the rig file states none");
    if (must_hold) {
        data.notes.push_back(
            "robot.interpolation = \"hold\": at this rate the robot's dead time is less than a period; "
            "the record does not show the robot");
    }
}

/* The records one after another, as segments of one. */
record read_all(const std::vector<std::string> &paths, rig &rig, std::vector<input_file> &inputs)
{
    record all;
    for (const std::string &path : paths) {
        record next = read_record(path, rig);
        inputs.push_back({"record", path, next.hash, next.content});
        if (all.size() == 0) {
            take_rate(rig, next);
            all = std::move(next);
            continue;
        }
        const std::size_t offset = all.size();
        check_row_count(path + " and those before it", offset + next.size());
        const double shift_s = all.time_s.back() + all.period_s - next.time_s.front();
        for (const auto signal : record_signals) {
            if ((all.*signal).empty() != (next.*signal).empty()) {
                throw input_error(path + ": has not the same signals as " + all.path);
            }
            (all.*signal).insert((all.*signal).end(), (next.*signal).begin(), (next.*signal).end());
        }
        if (!all.filled.empty() || !next.filled.empty()) {
            all.filled.resize(offset, 0);
            next.filled.resize(next.size(), 0);
            all.filled.insert(all.filled.end(), next.filled.begin(), next.filled.end());
        }
        for (const double time_s : next.time_s) {
            all.time_s.push_back(time_s + shift_s);
        }
        for (const record_segment &part : next.segments) {
            all.segments.push_back({part.begin + offset, part.end + offset, part.stands_m});
        }
        all.notes.insert(all.notes.end(), next.notes.begin(), next.notes.end());
        all.is_from_this_firmware = all.is_from_this_firmware && next.is_from_this_firmware;
    }
    return all;
}

} // namespace

records_of_request read_records(const diagnosis_request &request)
{
    records_of_request made;
    made.given = request.rig;
    made.fit = read_all(request.records, made.given, made.inputs);
    drive_by_measured_motion(made.fit);
    made.replayed = with_age_as_delay(made.given);
    refuse_copies(made.fit);
    refuse_mistaken_signals(made.fit, made.replayed);
    for (const auto &[role, path, one] : {std::make_tuple("validation", &request.validation, &made.validation),
                                          std::make_tuple("standstill", &request.standstill, &made.standstill),
                                          std::make_tuple("repetition", &request.repetition, &made.repetition)}) {
        if (!path->empty()) {
            *one = read_record(*path, made.replayed, one == &made.standstill);
            drive_by_measured_motion(**one);
            made.inputs.push_back({role, *path, (*one)->hash, (*one)->content});
        }
    }
    refuse_same(made.inputs);
    for (const auto *one : {&made.validation, &made.repetition}) {
        if (*one) {
            refuse_derived(**one, made.fit);
        }
    }
    if (made.validation && made.repetition) {
        refuse_derived(*made.repetition, *made.validation);
    }
    for (const auto &[argument, one] : {std::make_pair("--validate", &made.validation),
                                        {"--standstill", &made.standstill},
                                        {"--repeat", &made.repetition}}) {
        if (*one) {
            refuse_useless(**one, argument, made.fit);
        }
    }
    return made;
}

} // namespace berth
