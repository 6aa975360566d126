#include "bounce_finding.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "verdict_words.h"

namespace berth
{

std::optional<bounce_finding> bounces_of(const motion_evidence &motion, double manipulator_mass_kg)
{
    const std::vector<bounce> &all = motion.bounces;
    if (all.empty()) {
        return {};
    }
    std::vector<double> restitutions;
    std::vector<double> energies_J;
    for (const bounce &one : all) {
        restitutions.push_back(one.restitution());
        energies_J.push_back(
            0.5 * manipulator_mass_kg *
            (one.speed_out_m_per_s * one.speed_out_m_per_s - one.speed_in_m_per_s * one.speed_in_m_per_s));
    }
    std::sort(restitutions.begin(), restitutions.end());
    std::sort(energies_J.begin(), energies_J.end());
    return bounce_finding{all.size(), restitutions[all.size() / 2], restitutions.front(), restitutions.back(),
                          energies_J[all.size() / 2]};
}

bool is_bouncing(const motion_evidence &motion)
{
    constexpr std::size_t again_and_again = 3;
    return !motion.bounces.empty() && (!motion.touches_now || motion.bounces.size() >= again_and_again);
}

std::string bounce_words(const bounce_finding &bounces, const motion_evidence &motion)
{
    const std::string restitution = bounces.count == 1
                                        ? with_numbers("%.3g", bounces.restitution)
                                        : with_numbers("%.3g (%.3g to %.3g)", bounces.restitution,
                                                       bounces.restitution_lowest, bounces.restitution_highest);
    std::string words = std::to_string(bounces.count) + (bounces.count == 1 ? " bounce" : " bounces") +
                        ", restitution " + restitution +
                        (bounces.restitution > 1.0 ? ": a bounce gains " : ": a bounce loses ") +
                        with_numbers("%.3g J", std::abs(bounces.energy_J));
    if (!motion.touches_now) {
        const bounce &last = motion.bounces.back();
        words += with_numbers("; the tool touched the object for %.2f s, left it at %.2f s and did not come back",
                              last.left_s - last.touched_s, last.left_s);
    }
    return words;
}

} // namespace berth
