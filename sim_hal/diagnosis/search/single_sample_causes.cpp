#include "single_sample_causes.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "../decide/printable.h"

namespace berth
{

namespace
{

bool is_of_single_samples(const cause &known)
{
    return known.effect->is_of_single_samples;
}

/* Over the rows that were compared, and those that were not because of such samples. */
void show_error(block_diagnosis &block, const record &data, const record *unseen)
{
    const sample_events none;
    block_model model(block.block, data, block.as_given, none,
                      unseen == nullptr ? held_out_parts::two_tenths : held_out_parts::none);
    std::vector<row_use> uses = model.uses();
    for (std::size_t n = 0; n < uses.size(); n++) {
        uses[n] = block.uses[n] == row_use::none ? uses[n] : block.uses[n];
    }
    std::vector<double> error;
    for (const auto &[rig, member] :
         {std::pair(&block.retuned, &part_rms::retuned), {&block.as_given, &part_rms::before}}) {
        model.error(*rig, error);
        block.fit_rms.*member = rms_of(error, uses, row_use::fit);
        block.held_out_rms.*member = rms_of(error, uses, row_use::held_out);
        if (unseen != nullptr) {
            block_model other(block.block, *unseen, block.as_given, none, held_out_parts::none);
            std::vector<double> of_other;
            other.error(*rig, of_other);
            block.held_out_rms.*member = rms_of(of_other, other.uses(), row_use::fit);
        }
    }
    block.error_before = std::move(error); /* of the rig as given, the last one */
}

} // namespace

void show_error_with_single_samples(std::vector<block_diagnosis> &blocks, const record &data, const record *unseen)
{
    const bool any = std::any_of(blocks.begin(), blocks.end(), [](const block_diagnosis &block) {
        return std::any_of(block.causes.begin(), block.causes.end(), is_of_single_samples);
    });
    for (block_diagnosis &block : blocks) {
        if (any && block.block != block::manipulator) {
            show_error(block, data, unseen != nullptr && can_replay(*unseen, block.block) ? unseen : nullptr);
        }
    }
}

void tell_in_own_block(std::vector<block_diagnosis> &blocks)
{
    const auto find = [&](block which) {
        return std::find_if(blocks.begin(), blocks.end(),
                            [&](const block_diagnosis &block) { return block.block == which; });
    };
    const auto robot = find(block::robot);
    const auto force = find(block::force);
    if (robot == blocks.end() || force == blocks.end() || force->verdict != verdict::named) {
        return;
    }
    const auto moved = std::stable_partition(force->causes.begin(), force->causes.end(), [](const cause &known) {
        return !(is_of_single_samples(known) && known.effect->block() == "robot");
    });
    if (moved != force->causes.end() && robot->verdict == verdict::nothing_detectable) {
        robot->verdict = verdict::named;
    }
    std::for_each(moved, force->causes.end(), [](cause &known) { known.is_shown_by_force = true; });
    /* In front: the last cause is the one that the robot's rivals stand beside. */
    robot->causes.insert(robot->causes.begin(), std::make_move_iterator(moved),
                         std::make_move_iterator(force->causes.end()));
    force->causes.erase(moved, force->causes.end());
    if (force->causes.empty()) {
        force->verdict = verdict::nothing_detectable;
    }
}

void drop_what_explains_nothing(std::vector<block_diagnosis> &blocks, rig &extended)
{
    for (block_diagnosis &block : blocks) {
        for (std::size_t i = block.causes.size(); i-- > 0;) {
            const cause &told = block.causes[i];
            const char *const why = told.effect->is_of_single_samples
                                        ? why_not_printable({told.share_explained, false, {}, {}})
                                        : nullptr;
            if (why == nullptr) {
                continue;
            }
            for (const effect_parameter &parameter : told.effect->parameters) {
                const double as_given = value_of(block.as_given, parameter.key);
                set_number(block.extended, parameter.key, as_given);
                set_number(extended, parameter.key, as_given);
            }
            if (!block.doubts.empty()) {
                block.doubts.push_back(std::string(told.effect->name) + " was found, and " + why);
            }
            block.causes.erase(block.causes.begin() + static_cast<std::ptrdiff_t>(i));
            if (block.causes.empty()) {
                block.verdict = block.doubts.empty() ? verdict::nothing_detectable : verdict::unknown;
            }
        }
    }
}

} // namespace berth
