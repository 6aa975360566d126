#include <nanobind/stl/complex.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cmath>

#include "../../firmware/compensation/compensation.h"
#include "../compensation/measured_map.h"
#include "../stability/arm_loop.h"
#include "../stability/compensation_states.h"
#include "../stability/loop_timeline.h"
#include "answers.h"
#include "arrays.h"
#include "bindings.h"

namespace nb = nanobind;

namespace berth
{

namespace
{

nb::dict spectrum_of(const rig_handle &handle)
{
    const rig rig = handle.snapshot();
    std::vector<std::complex<double>> z;
    std::vector<double> growth_per_s;
    std::vector<double> frequency_Hz;
    std::vector<double> damping_ratio;
    spectrum found;
    {
        const nb::gil_scoped_release released;
        found = deciding_spectrum(rig);
        for (const mode &one : found.modes) {
            z.push_back(one.z);
            growth_per_s.push_back(one.growth_per_s);
            frequency_Hz.push_back(one.frequency_Hz);
            damping_ratio.push_back(one.damping_ratio);
        }
    }
    nb::dict made;
    made["z"] = as_array(std::move(z));
    made["mode_growth_per_s"] = as_array(std::move(growth_per_s));
    made["mode_frequency_Hz"] = as_array(std::move(frequency_Hz));
    made["mode_damping_ratio"] = as_array(std::move(damping_ratio));
    made["spectral_radius"] = found.spectral_radius;
    made["growth_per_s"] = found.growth_per_s;
    return made;
}

/* Growth and radius of rigs with other values of these keys, and why one was refused: (index, line). */
nb::dict growth_of_many(const rig_handle &handle, const std::vector<std::string> &keys,
                        const nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu> &values)
{
    if (values.shape(1) != keys.size()) {
        throw input_error("vary", "values", "must have one column for each key");
    }
    const rig rig = handle.snapshot();
    varied_growth found;
    {
        const nb::gil_scoped_release released;
        found = growth_of_varied(rig, keys, values.data(), values.shape(0));
    }
    nb::list refused;
    for (std::size_t i = 0; i < found.refusal.size(); i++) {
        if (!found.refusal[i].empty()) {
            refused.append(nb::make_tuple(i, found.refusal[i]));
        }
    }
    nb::dict made;
    made["growth_per_s"] = as_array(std::move(found.growth_per_s));
    made["spectral_radius"] = as_array(std::move(found.spectral_radius));
    made["refused"] = refused;
    return made;
}

/* As `berth eigen`. */
nb::dict answer(const rig_handle &handle, bool whole)
{
    const rig rig = handle.snapshot();
    std::optional<model_answer> found;
    {
        const nb::gil_scoped_release released;
        found = answer_of(rig, predictor_at(amplitude_of(rig)), {},
                          whole ? answer_scope::whole : answer_scope::verdict_alone);
    }
    return as_dict(found->verdict(), found->margin, found->worst.prediction);
}

struct limit_row {
    std::string key;
    double value;
    std::optional<double> below;
    std::optional<double> above;
    std::vector<stable_interval> stable; /* none of a compensated loop */
};

std::vector<limit_row> rows_of(const rig &original)
{
    std::vector<limit_row> rows;
    const double amplitude_m = amplitude_of(original);
    if (compensation_is_on(&original.firmware) || (original.firmware.arm.kind != ARM_NONE && amplitude_m == 0.0)) {
        for (const compensated_limit &one : limits_of_compensated(original)) {
            rows.push_back({std::string(one.key), one.value, one.below, one.above, {}});
        }
        return rows;
    }
    const rig worst = has_schedule(original) ? worst_of_schedule(original, predictor_at(amplitude_m)).rig : original;
    const rig steady = is_time_varying(worst) ? without_variation(worst) : worst;
    if (drifts_freely(linear_at(steady, amplitude_m))) {
        throw input_error(
            original.name, "object.stiffness_N_per_m",
            "neither this nor manipulator.stiffness_N_per_m holds the two bodies anywhere: they may drift "
            "together for ever; give one of them a stiffness");
    }
    for (const parameter_limits &one : limits_of(steady, amplitude_m)) {
        const stability_limit *const below = one.nearest_below();
        const stability_limit *const above = one.nearest_above();
        rows.push_back({std::string(one.key), one.value,
                        below != nullptr ? std::optional(below->value) : std::nullopt,
                        above != nullptr ? std::optional(above->value) : std::nullopt, one.stable});
    }
    return rows;
}

nb::dict limits(const rig_handle &handle)
{
    const rig rig = handle.snapshot();
    std::vector<limit_row> rows;
    {
        const nb::gil_scoped_release released;
        rows = rows_of(rig);
    }
    nb::dict made;
    for (const limit_row &row : rows) {
        nb::list stable;
        for (const stable_interval &interval : row.stable) {
            stable.append(nb::make_tuple(interval.from, interval.to));
        }
        nb::dict one;
        one["value"] = row.value;
        one["below"] = or_none(row.below);
        one["above"] = or_none(row.above);
        one["stable_intervals"] = stable;
        made[row.key.c_str()] = one;
    }
    return made;
}

map_axis axis_of(const std::string &key, double from, double to, int count)
{
    const rig_key *const known = find_key(key);
    if (known == nullptr) {
        throw input_error("map", key, "unknown key; the nearest known one is " + std::string(nearest_key(key)));
    }
    if (known->type != key_type::number && known->type != key_type::integer) {
        throw input_error("map", key, "is no number");
    }
    if (!std::isfinite(from) || !std::isfinite(to) || count < 2) {
        throw input_error("map", key, "an axis is (key, from, to, count) with finite ends and at least 2 points");
    }
    return {key, from, to, count};
}

nb::dict map(const rig_handle &handle, const map_axis &x, const map_axis &y, int threads)
{
    const rig rig = handle.snapshot();
    std::vector<double> radius;
    std::vector<double> growth_per_s;
    bool is_measured = false;
    {
        const nb::gil_scoped_release released;
        map_request request;
        request.kind = map_kind::keys;
        request.has_flight = rig.object.kind == object_kind::contact && rig.firmware.arm.kind == ARM_NONE;
        request.x = x;
        request.y = y;
        is_measured = !compensation_is_linear(rig);
        if (!is_measured && is_time_varying(rig)) {
            throw input_error(rig.name + ": the loop changes from tick to tick: `berth map` has its exponents");
        }
        request.amplitude_m = is_measured ? 0.0 : amplitude_of(rig);
        request.rig = is_measured ? released_rig(rig, 0.0) : request.amplitude_m == 0.0 ? in_contact(rig) : rig;
        if (is_measured) {
            for (const measured_point &point : compute_measured_map(request, compensated_run_s, threads)) {
                growth_per_s.push_back(point.growth_per_s);
            }
        } else {
            radius = compute_map(request, threads).spectral_radius;
        }
        map_point_setter setter(request);
        for (std::size_t i = 0; i < request.points(); i++) {
            const auto columns = static_cast<std::size_t>(x.count);
            const bool is_possible = setter.set(x.value(static_cast<int>(i % columns)),
                                                y.value(static_cast<int>(i / columns))) == point_state::possible;
            const double period_s = config_period_s(&setter.rig().firmware);
            if (is_measured) {
                radius.push_back(is_possible ? std::exp(growth_per_s[i] * period_s) : std::nan(""));
            } else {
                growth_per_s.push_back(is_possible ? std::log(radius[i]) / period_s : std::nan(""));
            }
        }
    }
    nb::dict made;
    made["spectral_radius"] = as_array(std::move(radius));
    made["growth_per_s"] = as_array(std::move(growth_per_s));
    made["method"] = is_measured ? "time domain" : "eigenvalues";
    return made;
}

nb::dict as_dict(const method_verdict &method)
{
    nb::dict made;
    made["method"] = method.method.name;
    made["settings"] = nb::cast(method.method.settings);
    made["robust"] = method.is_robust;
    made["error"] = method.error;
    made["worst_error"] = method.worst_error;
    return made;
}

nb::dict compensate(const rig_handle &handle, double duration_s)
{
    choice_request request;
    request.rig = handle.get();
    request.duration_s = duration_s;
    std::optional<choice> made;
    recommendation found;
    {
        const nb::gil_scoped_release released;
        refuse_arm(request.rig);
        made = choose_compensation(request);
        found = recommend(*made, request.rig);
    }
    nb::list methods;
    for (const method_verdict &method : made->methods) {
        methods.append(as_dict(method));
    }
    nb::list passed_over;
    for (const unsafe_method &one : found.passed_over) {
        passed_over.append(nb::make_tuple(one.name, one.because));
    }
    nb::dict told;
    told["methods"] = methods;
    told["recommended"] = found.best != nullptr ? nb::cast(found.best->method.name) : nb::none();
    told["settings"] = found.best != nullptr ? nb::cast(found.best->method.settings) : nb::none();
    told["passed_over"] = passed_over;
    return told;
}

nb::dict as_dict(const growth_prediction &predicted)
{
    static const char *const sources[] = {nullptr, "eigenvalues", "contact", "lyapunov_exponent", "run"};
    const char *const source = sources[static_cast<int>(predicted.source)];
    nb::dict made;
    made["growth_per_s"] = or_none(predicted.growth_per_s);
    made["growth_ci95_per_s"] = predicted.ci95_per_s;
    made["source"] = source != nullptr ? nb::cast(source) : nb::none();
    made["restitution"] = or_none(predicted.restitution);
    made["why_not_predicted"] = predicted.why_not.empty() ? nb::none() : nb::cast(predicted.why_not);
    return made;
}

} // namespace

nb::dict as_dict(const stability_verdict &verdict, const stability_margin &margin,
                 const growth_prediction &predicted)
{
    nb::dict made;
    made["verdict"] = verdict_name(verdict.kind);
    made["stable"] = or_none(verdict.is_stable);
    made["because"] = verdict.because;
    made["advice"] = verdict.advice.empty() ? nb::none() : nb::cast(verdict.advice);
    made["caveat"] = verdict.caveat.empty() ? nb::none() : nb::cast(verdict.caveat);
    made["growth_per_s"] = verdict.growth ? nb::cast(verdict.growth->growth_per_s) : nb::none();
    made["growth_ci95_per_s"] = verdict.growth ? nb::cast(verdict.growth->ci95_per_s) : nb::none();
    made["frequency_Hz"] = verdict.growth ? nb::cast(verdict.growth->frequency_Hz) : nb::none();
    made["stop_cause"] = verdict.stop ? nb::cast(stop_cause_name(verdict.stop->cause)) : nb::none();
    made["stop_after_s"] = verdict.stop ? nb::cast(verdict.stop->after_s) : nb::none();
    made["dead_time_margin_ms"] = or_none(margin.dead_time_ms);
    made["dead_time_margin_is_open"] = margin.is_dead_time_open;
    made["unlimited"] = margin.is_unlimited;
    made["modulus"] = or_none(margin.modulus);
    made["margin_note"] = margin.note.empty() ? nb::none() : nb::cast(margin.note);
    made["prediction"] = as_dict(predicted);
    return made;
}

void bind_answers(nb::module_ &module)
{
    nb::class_<map_axis>(module, "Axis", "Values from..to in equal steps, both ends included.")
        .def(
            "__init__",
            [](map_axis *made, const std::string &key, double from, double to, int count) {
                new (made) map_axis(axis_of(key, from, to, count));
            },
            nb::arg("key"), nb::arg("start"), nb::arg("stop"), nb::arg("count"))
        .def_ro("key", &map_axis::name)
        .def_prop_ro("values", [](const map_axis &axis) {
            std::vector<double> values;
            values.reserve(static_cast<std::size_t>(axis.count));
            for (int i = 0; i < axis.count; i++) {
                values.push_back(axis.value(i));
            }
            return as_array(std::move(values));
        });
    module.def("spectrum", &spectrum_of, nb::arg("rig"));
    module.def("growth_of_many", &growth_of_many, nb::arg("rig"), nb::arg("keys"), nb::arg("values"));
    module.def("answer", &answer, nb::arg("rig"), nb::arg("whole"));
    module.def("limits", &limits, nb::arg("rig"));
    module.def("map", &map, nb::arg("rig"), nb::arg("x"), nb::arg("y"), nb::arg("threads"));
    module.def("compensate", &compensate, nb::arg("rig"), nb::arg("duration_s"));
}

} // namespace berth
