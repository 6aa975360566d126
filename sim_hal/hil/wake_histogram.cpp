#include "wake_histogram.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "../../hal/rig/rig_file.h"
#include "csv_cells.h"

namespace berth
{

namespace
{

using json = nlohmann::json;

const json *member(const json &object, const char *name)
{
    const auto found = object.is_object() ? object.find(name) : object.end();
    return found == object.end() ? nullptr : &*found;
}

std::int64_t parse_lateness(const std::string &text, const std::string &origin)
{
    std::int64_t lateness = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), lateness);
    if (error != std::errc() || end != text.data() + text.size() || lateness < 0 || lateness > 1000000000) {
        throw input_error(origin + ": histogram: \"" + printable_cell(text) +
                          "\" is no lateness, which is a whole number from 0 to 1e9");
    }
    return lateness;
}

constexpr double count_max = 1e15; /* 80000 years at 400 Hz */

double parse_count(const std::string &lateness, const json &value, const std::string &origin)
{
    const double count = value.is_number() ? value.get<double>() : -1.0;
    if (!(count >= 0.0 && count <= count_max) || count != std::floor(count)) {
        throw input_error(origin + ": histogram: the count at \"" + lateness +
                          "\" must be a whole number, 0 or more and at most 1e15 (is " +
                          printable_cell(value.dump()) + ")");
    }
    return count;
}

/* Adds a thread's histogram to `counts`; false if it has none. */
bool add_thread(const json &thread, const std::string &origin, std::map<std::int64_t, double> &counts,
                double &cycles)
{
    const json *const histogram = member(thread, "histogram");
    if (histogram == nullptr || !histogram->is_object()) {
        return false;
    }
    for (const auto &[lateness, value] : histogram->items()) {
        const std::int64_t key = parse_lateness(lateness, origin);
        counts[key] += parse_count(lateness, value, origin);
    }
    const json *const counted = member(thread, "cycles");
    cycles += counted != nullptr && counted->is_number() ? std::min(counted->get<double>(), count_max) : 0.0;
    return true;
}

} // namespace

wake_histogram parse_wake_histogram(std::string_view text, const std::string &origin)
{
    const json root = json::parse(text, nullptr, false);
    if (root.is_discarded()) {
        throw input_error(origin + ": is not JSON; write it with cyclictest --json=FILE --histogram=US");
    }
    std::map<std::int64_t, double> counts;
    double cycles = 0.0;
    bool has_histogram = false;
    if (const json *const threads = member(root, "thread"); threads != nullptr && threads->is_object()) {
        for (const json &thread : *threads) {
            has_histogram |= add_thread(thread, origin, counts, cycles);
        }
    }
    if (!has_histogram) {
        throw input_error(origin + ": has no histogram at thread.0.histogram; give cyclictest --histogram=US");
    }
    const json *const resolution = member(root, "resolution_in_ns");
    const bool is_in_ns = resolution != nullptr && *resolution == 1;
    wake_histogram result;
    for (const auto &[lateness, count] : counts) {
        if (count > 0.0) {
            result.lateness_ns.push_back(is_in_ns ? lateness : 1000 * lateness);
            result.wakes += count;
            result.mean_ns += count * static_cast<double>(result.lateness_ns.back());
            result.share.push_back(result.wakes);
        }
    }
    if (result.lateness_ns.empty() || !std::isfinite(result.wakes)) {
        throw input_error(origin + ": the histogram is empty");
    }
    for (double &share : result.share) {
        share /= result.wakes;
    }
    result.mean_ns /= result.wakes;
    result.left_out = std::max(0.0, cycles - result.wakes);
    return result;
}

std::string left_out_note(const wake_histogram &histogram)
{
    if (histogram.left_out <= 0.0) {
        return {};
    }
    char text[160];
    std::snprintf(text, sizeof text, "%.0f of %.0f wake-ups are later than that file's histogram reaches: left out",
                  histogram.left_out, histogram.left_out + histogram.wakes);
    return text;
}

bool fits_period(const wake_histogram &histogram, const rig &rig)
{
    return histogram.max_ns() < config_period_ns(&rig.firmware);
}

wake_histogram load_wake_histogram(const rig &rig)
{
    const std::string &path = rig.run.lateness_file;
    if (path.empty()) {
        return {};
    }
    wake_histogram histogram = parse_wake_histogram(read_file(path, written_bytes_max), path);
    if (!fits_period(histogram, rig)) {
        char text[160];
        std::snprintf(text, sizeof text,
                      ": a lateness of %g us is not less than the period of %g us: such a tick would be missed",
                      1e-3 * static_cast<double>(histogram.max_ns()), 1e6 * config_period_s(&rig.firmware));
        throw input_error(path + text);
    }
    return histogram;
}

wake_lateness::wake_lateness(wake_histogram histogram, std::int64_t seed)
    : histogram_(std::move(histogram)), random_(seed, stream_lateness)
{
}

std::int64_t wake_lateness::next_ns()
{
    if (histogram_.lateness_ns.empty()) {
        return 0;
    }
    const auto found = std::upper_bound(histogram_.share.begin(), histogram_.share.end(), random_.uniform());
    const auto place = std::min<std::ptrdiff_t>(found - histogram_.share.begin(),
                                                static_cast<std::ptrdiff_t>(histogram_.share.size()) - 1);
    return histogram_.lateness_ns[static_cast<std::size_t>(place)];
}

} // namespace berth
