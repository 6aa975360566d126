#include "bounce_finding.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "verdict_words.h"

namespace berth
{

namespace
{

double median(std::vector<double> values)
{
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/* The interval of the median, of 95 %, by the ranks that bound it; fewer than six bounces have none. */
bool holds_1(const std::vector<double> &rising)
{
    const auto count = static_cast<double>(rising.size());
    const double half = 0.5 * 1.96 * std::sqrt(count);
    const double low = std::floor(0.5 * count - half);
    const double high = std::ceil(0.5 * count + half);
    return low >= 0.0 && high < count && rising[static_cast<std::size_t>(low)] <= 1.0 &&
           rising[static_cast<std::size_t>(high)] >= 1.0;
}

/* What an operator gives to a tool that is in the material is in its speed afterwards. */
std::vector<bounce> without_operator(const std::vector<bounce> &all, double mass_kg)
{
    constexpr double little = 0.01; /* of the energy that the tool came with */
    std::vector<bounce> found;
    std::copy_if(all.begin(), all.end(), std::back_inserter(found), [mass_kg](const bounce &one) {
        const double came_with_J = 0.5 * mass_kg * one.speed_in_m_per_s * one.speed_in_m_per_s;
        return std::abs(one.operator_J) <= little * came_with_J;
    });
    return found;
}

} // namespace

std::optional<bounce_finding> bounces_of(const motion_evidence &motion, double manipulator_mass_kg)
{
    const std::vector<bounce> by_themselves = without_operator(motion.bounces, manipulator_mass_kg);
    const bool is_driven = by_themselves.empty();
    const std::vector<bounce> &all = is_driven ? motion.bounces : by_themselves;
    if (all.empty()) {
        return {};
    }
    std::vector<double> restitutions;
    std::vector<double> energies_J;
    std::vector<double> differences_m_per_s;
    std::vector<double> noises_m_per_s;
    for (const bounce &one : all) {
        restitutions.push_back(one.restitution());
        energies_J.push_back(
            0.5 * manipulator_mass_kg *
            (one.speed_out_m_per_s * one.speed_out_m_per_s - one.speed_in_m_per_s * one.speed_in_m_per_s));
        differences_m_per_s.push_back(std::abs(one.speed_out_m_per_s - one.speed_in_m_per_s));
        noises_m_per_s.push_back(one.speed_noise_m_per_s);
    }
    std::sort(restitutions.begin(), restitutions.end());
    std::sort(energies_J.begin(), energies_J.end());
    constexpr double ci95 = 1.96;
    const bool is_noise = median(differences_m_per_s) <= ci95 * median(noises_m_per_s);
    return bounce_finding{all.size(),
                          restitutions[all.size() / 2],
                          restitutions.front(),
                          restitutions.back(),
                          energies_J[all.size() / 2],
                          is_noise || holds_1(restitutions),
                          is_driven};
}

bool is_bouncing(const motion_evidence &motion)
{
    constexpr std::size_t again_and_again = 3;
    return !motion.bounces.empty() && (!motion.touches_now || motion.bounces.size() >= again_and_again);
}

std::string bounce_words(const bounce_finding &bounces, const motion_evidence &motion)
{
    std::string restitution = with_numbers("%.3g", bounces.restitution);
    const std::string lowest = with_numbers("%.3g", bounces.restitution_lowest);
    const std::string highest = with_numbers("%.3g", bounces.restitution_highest);
    if (lowest != highest) {
        restitution += " (" + lowest + " to " + highest + ")";
    }
    std::string words =
        std::to_string(bounces.count) + (bounces.count == 1 ? " bounce" : " bounces") + ", restitution " +
        restitution +
        (bounces.is_driven ? ": the operator's work is in it, so that it does not tell what the loop does"
         : bounces.is_even ? ": whether a bounce gains or loses energy does not show"
         : bounces.gains() ? ": a bounce gains "
                           : ": a bounce loses ") +
        (bounces.is_driven || bounces.is_even ? "" : with_numbers("%.3g J", std::abs(bounces.energy_J)));
    if (!motion.touches_now) {
        const bounce &last = motion.bounces.back();
        words += with_numbers("; the tool touched the object for %.2f s, left it at %.2f s and did not come back",
                              last.left_s - last.touched_s, last.left_s);
    }
    return words;
}

} // namespace berth
