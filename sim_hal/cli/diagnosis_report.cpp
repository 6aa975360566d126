#include "diagnosis_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "../../hal/rig/keys.h"
#include "../diagnosis/search/acceptance.h"

namespace berth
{

interval interval_of(const parameter_estimate &parameter)
{
    const rig_key *const key = find_key(parameter.key);
    constexpr std::string_view probability = "_probability";
    const bool is_probability =
        parameter.key.size() > probability.size() &&
        std::string_view(parameter.key).substr(parameter.key.size() - probability.size()) == probability;
    const double low = key == nullptr ? -unlimited : key->low;
    const double high = is_probability ? 1.0 : key == nullptr ? unlimited : key->high;
    return {std::max(parameter.value - parameter.ci95, std::min(low, parameter.value)),
            std::min(parameter.value + parameter.ci95, std::max(high, parameter.value))};
}

bool is_fitted(const parameter_estimate &parameter)
{
    return parameter.ci95 != 0.0;
}

bool has_rest(const block_diagnosis &block)
{
    return block.verdict == verdict::unknown || block.verdict == verdict::partly_explained;
}

bool is_floor_open(const block_diagnosis &block)
{
    return has_rest(block) && !block.floor_is_measured;
}

interval interval_of_floor(const block_diagnosis &block)
{
    const double low = is_floor_open(block) ? 0.0 : block.floor.rms - block.floor_ci95;
    return {std::max(0.0, low), block.floor.rms + block.floor_ci95};
}

namespace
{

/* Name, value and how well it is known. */
std::string words_of(const parameter_estimate &parameter)
{
    const std::string name = parameter.key.substr(parameter.key.find('.') + 1);
    const interval known = interval_of(parameter);
    const bool is_cut =
        known.low > parameter.value - parameter.ci95 || known.high < parameter.value + parameter.ci95;
    char text[200];
    if (!is_fitted(parameter)) {
        std::snprintf(text, sizeof text, "%s = %.5g, as given", name.c_str(), parameter.value);
    } else if (is_cut) {
        std::snprintf(text, sizeof text, "%s = %.5g (%.2g to %.2g)", name.c_str(), parameter.value, known.low,
                      known.high);
    } else {
        std::snprintf(text, sizeof text, "%s = %.5g +- %.2g", name.c_str(), parameter.value, parameter.ci95);
    }
    return text;
}

/* A share of the error. Where some is left it is never all of it. */
std::string share_words(double share, bool has_rest)
{
    char text[40];
    const int digits_max = has_rest ? 4 : 1;
    for (int digits = 1; digits <= digits_max; digits++) {
        std::snprintf(text, sizeof text, "%.*f %%", digits, 100.0 * share);
        if (std::strtod(text, nullptr) < 100.0) {
            return text;
        }
    }
    return has_rest ? "nearly all" : text;
}

void print_cause(const cause &known, bool has_rest)
{
    std::printf("  cause          %s\n", std::string(known.effect->name).c_str());
    for (const parameter_estimate &parameter : known.parameters) {
        std::printf("                 %s\n", words_of(parameter).c_str());
    }
    if (known.effect->is_of_single_samples) {
        std::printf("                 seen in single samples\n");
        if (known.share_explained > 0.0) { /* else it is not known */
            std::printf("                 explains %s of the explainable error%s\n",
                        share_words(known.share_explained, has_rest).c_str(),
                        known.is_shown_by_force ? " of the force" : "");
        }
        return;
    }
    std::printf("                 explains %s of the explainable error, BIC better by %.0f\n",
                share_words(known.share_explained, has_rest).c_str(), known.delta_bic);
    std::printf("                 gain on unseen data %.1f %% (%.1f to %.1f)\n", 100.0 * known.held_out_gain,
                100.0 * known.held_out_gain_low, 100.0 * known.held_out_gain_high);
}

/* What nothing explains: how much, in which band, state and class. */
void print_rest(const block_diagnosis &block, const record &data)
{
    const error_place place = find_error_place(block, data);
    std::printf("  left           %.3g %s rms, %.3g times the noise", block.fit_rms.after,
                block_units[static_cast<int>(block.block)].data(),
                block.fit_rms.after / std::max(block.fit_rms.floor, 1e-300));
    if (place.band) {
        std::printf(", most of it from %.3g to %.3g Hz", place.band->low_Hz, place.band->high_Hz);
    }
    std::printf("\n");
    constexpr double more_than_its_share = 0.3; /* a quarter has a quarter of noise */
    if (place.share > more_than_its_share) {
        std::printf("                 the quarter of the rows %s has %.0f %% of its square\n",
                    std::string(place.state).c_str(), 100.0 * place.share);
    }
    constexpr double worth_a_word = 0.001; /* of the explainable error */
    if (block.left > worth_a_word) {
        const double percent = 100.0 * block.left;
        std::printf("                 by its class it is %s, %.*f %% of the explainable error\n",
                    error_class_names[static_cast<int>(block.left_class)].data(), percent < 10.0 ? 1 : 0, percent);
    }
}

void print_doubts(const block_diagnosis &block)
{
    const char *title = "open";
    for (const std::string_view why : block.doubts) {
        std::printf("  %-14s %s\n", title, why.data());
        title = "";
    }
}

void print_block(const block_diagnosis &block, const record &data)
{
    const char *const unit = block_units[static_cast<int>(block.block)].data();
    std::printf("%s: %s\n", block_names[static_cast<int>(block.block)].data(),
                verdict_names[static_cast<int>(block.verdict)].data());
    std::printf("  error          %.3g %s rms as given, %.3g re-tuned, %.3g extended; the noise is ",
                block.fit_rms.before, unit, block.fit_rms.retuned, block.fit_rms.after);
    if (is_floor_open(block)) {
        std::printf("%.3g at most, estimated beside what is left\n", interval_of_floor(block).high);
    } else {
        std::printf("%.3g +- %.2g%s\n", block.fit_rms.floor, block.floor_ci95,
                    block.floor_is_measured ? "" : ", estimated");
    }
    std::printf("  on unseen data %.3g %s re-tuned, %.3g extended\n", block.held_out_rms.retuned, unit,
                block.held_out_rms.after);
    for (const cause &known : block.causes) {
        print_cause(known, has_rest(block));
    }
    for (const alternative &other : block.alternatives) {
        std::printf("  or             %s, BIC %.1f %s\n", std::string(other.effect->name).c_str(),
                    std::abs(other.delta_bic),
                    other.delta_bic > 0.0              ? "worse"
                    : other.delta_bic > -bic_undecided ? "better"
                                                       : "better, but not proven on unseen data");
    }
    if (has_rest(block)) {
        print_rest(block, data);
    }
    print_doubts(block);
}

/* Words one after another, in lines that are not too long. */
void print_list(const char *title, const std::vector<std::string> &words)
{
    constexpr std::size_t columns_max = 100;
    std::string line = "  " + std::string(title);
    line.resize(16, ' ');
    for (std::size_t i = 0; i < words.size(); i++) {
        const std::string word = " " + words[i] + (i + 1 < words.size() ? "," : "");
        if (line.size() + word.size() > columns_max) {
            std::printf("%s\n", line.c_str());
            line.assign(16, ' ');
        }
        line += word;
    }
    if (!words.empty()) {
        std::printf("%s\n", line.c_str());
    }
}

void print_detectable(const std::vector<detectable_size> &sizes)
{
    std::vector<std::string> seen;
    std::vector<std::string> unseen;
    for (const detectable_size &one : sizes) {
        char text[100];
        if (one.value) {
            std::snprintf(text, sizeof text, "%s %.3g", std::string(one.key).c_str(), *one.value);
            seen.emplace_back(text);
        } else {
            unseen.emplace_back(one.effect->name);
        }
    }
    if (!sizes.empty()) {
        std::printf("what this record would have shown, 19 times in 20:\n");
        print_list("from", seen);
        print_list("in no size", unseen);
    }
}

void print_next(const diagnosis &found, const std::string &out_folder)
{
    if (!found.next) {
        return;
    }
    const next_experiment &next = *found.next;
    if (next.proposed) {
        std::printf("next experiment: %s\n  why            %s\n  play it        build/berth run %s/given.toml "
                    "--profile %s/%s --set "
                    "run.duration_s=%.6g\n",
                    words_of(*next.proposed, found.given).c_str(), next.why.c_str(), out_folder.c_str(),
                    out_folder.c_str(), next_experiment_file, found.given.run.release_s + next.proposed->duration_s);
    } else {
        std::printf("next experiment: none; %s\n", next.why.c_str());
    }
    if (!next.calibration.empty()) {
        std::printf("  instead        %s\n", next.calibration.c_str());
    }
}

} // namespace

void print_diagnosis(const diagnosis &found, const std::string &out_folder)
{
    std::printf("verdict: %s%s%s\n", verdict_names[static_cast<int>(found.verdict)].data(),
                found.located.empty() ? "" : ", in the ", found.located.c_str());
    for (const block_diagnosis &block : found.blocks) {
        if (block.unseen_times_noise > 0.0) {
            std::printf("unseen data: the error of the %s is %.3g %s rms, %.2g times the noise\n",
                        block_names[static_cast<int>(block.block)].data(), block.held_out_rms.after,
                        block_units[static_cast<int>(block.block)].data(), block.unseen_times_noise);
        }
    }
    for (const block_diagnosis &block : found.blocks) {
        print_block(block, found.data);
    }
    for (const block block : found.not_described) {
        std::printf("%s: not described, not judged\n", block_names[static_cast<int>(block)].data());
    }
    print_detectable(found.detectable);
    print_next(found, out_folder);
    for (const std::string &note : found.notes) {
        std::printf("note: %s\n", note.c_str());
    }
}

} // namespace berth
