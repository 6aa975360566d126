#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>

#include <cstring>

#include "../../firmware/limits.h"
#include "../../hal/live_sample.h"
#include "../../hal/log_file.h"
#include "../log/ulog_reader.h"
#include "answers.h"
#include "arrays.h"
#include "bindings.h"

namespace nb = nanobind;

namespace berth
{

namespace
{

using record_bytes = nb::ndarray<const std::uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using number_array = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

nb::object peak_or_none(const std::optional<force_peak> &peak)
{
    return peak ? nb::object(nb::make_tuple(peak->force_N, peak->at_s)) : nb::none();
}

/* As `berth run`. "ticks": the bytes of the records, as `tick_format` describes them. */
nb::dict run(const rig_handle &handle, const std::string &log_path, bool whole)
{
    const rig rig = handle.snapshot();
    played_run made;
    {
        const nb::gil_scoped_release released;
        made = play(rig, log_path, whole ? answer_scope::whole : answer_scope::verdict_alone);
    }
    nb::dict told = as_dict(made.answer.verdict, made.answer.margin, made.answer.predicted);
    told["measured_peak"] = peak_or_none(made.evidence.measured_peak);
    told["true_peak"] = peak_or_none(made.evidence.true_peak);
    told["ticks"] = as_bytes(std::move(made.ticks));
    return told;
}

/* Every whole record of a log, by topic: its format, and the bytes. */
nb::dict read_log(const std::string &path)
{
    struct topic {
        std::string format;
        std::vector<char> bytes;
    };
    std::map<std::string, topic> topics;
    std::optional<ulog_reader> reader;
    std::optional<rig> recorded;
    {
        const nb::gil_scoped_release released;
        reader.emplace(path);
        recorded = reader->recorded_rig();
        std::uint16_t id = 0;
        std::string_view record;
        const std::map<std::uint16_t, const char *> formats = {{ULOG_TICK_ID, tick_record_format},
                                                               {ULOG_FRAME_ID, frame_record_format},
                                                               {ULOG_ARM_ID, arm_record_format},
                                                               {ULOG_SIDE_ID, side_record_format}};
        while (reader->next(id, record)) {
            if (const auto known = formats.find(id); known != formats.end()) {
                const std::string format = known->second;
                topic &into = topics[format.substr(0, format.find(':'))];
                into.format = format;
                into.bytes.insert(into.bytes.end(), record.begin(), record.end());
            }
        }
    }
    nb::dict by_name;
    for (auto &[name, topic] : topics) {
        by_name[name.c_str()] = nb::make_tuple(topic.format, as_bytes(std::move(topic.bytes)));
    }
    const log_condition &condition = reader->condition();
    nb::dict told;
    told["topics"] = by_name;
    told["rig"] = nb::cast(rig_handle(*recorded));
    told["infos"] = nb::cast(reader->infos());
    told["cut"] = condition.is_cut;
    told["whole_until_s"] = or_none(condition.whole_until_s);
    return told;
}

/* The datagrams that a target would send of these ticks. */
nb::list live_samples(live_thinner &thinner, const record_bytes &ticks)
{
    nb::list all;
    for (std::size_t at = 0; at + sizeof(tick_record) <= ticks.size(); at += sizeof(tick_record)) {
        tick_record record;
        std::memcpy(&record, ticks.data() + at, sizeof record);
        if (thinner.add(record)) {
            const std::string json = thinner.json(0);
            all.append(nb::bytes(json.data(), json.size()));
        }
    }
    return all;
}

/* Of a manipulator's motion; None where it does not swing often enough. */
nb::object growth_of(const number_array &position_m, double period_s)
{
    const std::vector<double> signal(position_m.data(), position_m.data() + position_m.size());
    const auto fit = fit_growth(signal, period_s, growth_floor_m);
    return fit ? nb::object(nb::make_tuple(fit->growth_per_s, fit->growth_ci95_per_s, fit->frequency_Hz))
               : nb::none();
}

nb::list names(int count, const char *(*name_of)(int))
{
    nb::list all;
    for (int i = 0; i < count; i++) {
        all.append(name_of(i));
    }
    return all;
}

void bind_live(nb::module_ &module)
{
    nb::class_<live_thinner>(module, "LiveThinner", "Makes the samples of a live view of a run's ticks.")
        .def(
            "__init__",
            [](live_thinner *self, const rig_handle &of, std::uint32_t run, double rate_Hz) {
                const rig &rig = of.get();
                new (self) live_thinner({rig.name, config_hash(rig), config_period_ns(&rig.firmware), run}, rate_Hz);
            },
            nb::arg("rig"), nb::arg("run"), nb::arg("rate_Hz"))
        .def("samples", &live_samples, nb::arg("ticks"));
    module.def("growth_of", &growth_of, nb::arg("position_m"), nb::arg("period_s"));
    module.attr("live_rate_Hz") = live_rate_Hz;
    module.attr("growth_floor_m") = growth_floor_m;
    module.attr("state_names") =
        names(SUPERVISOR_STATE_COUNT, [](int i) { return supervisor_state_name(static_cast<supervisor_state>(i)); });
    module.attr("stop_cause_names") =
        names(STOP_CAUSE_COUNT, [](int i) { return stop_cause_name(static_cast<stop_cause>(i)); });
    module.attr("limit_names") = names(LIMIT_COUNT, [](int i) { return limit_names[i]; });
}

} // namespace

void bind_runs(nb::module_ &module)
{
    module.attr("tick_format") = tick_record_format;
    module.attr("tick_bytes") = sizeof(tick_record);
    module.def("run", &run, nb::arg("rig"), nb::arg("log_path"), nb::arg("whole"));
    module.def("read_log", &read_log, nb::arg("path"));
    bind_live(module);
}

} // namespace berth
