#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>

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

} // namespace

void bind_runs(nb::module_ &module)
{
    module.attr("tick_format") = tick_record_format;
    module.attr("tick_bytes") = sizeof(tick_record);
    module.def("run", &run, nb::arg("rig"), nb::arg("log_path"), nb::arg("whole"));
    module.def("read_log", &read_log, nb::arg("path"));
}

} // namespace berth
