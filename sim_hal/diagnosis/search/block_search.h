/* The search for the causes in one block: a base model, then one effect after the other as long as each is believed,
 * then what to say of it. */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_BLOCK_SEARCH_H
#define SIM_HAL_DIAGNOSIS_SEARCH_BLOCK_SEARCH_H

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "../decide/printable.h"
#include "../fit/gain.h"
#include "block_diagnosis.h"

namespace berth
{

class block_search
{
  public:
    block_search(block block, const diagnosis_input &input, const rig &given, const events_of_records &events);

    void run(block_diagnosis &result);

  private:
    /* --- the base, and what is above the floor: block_search.cpp --- */

    /* The base model's, and those of the robot before it as far as its own channel left them open. */
    std::vector<free_parameter> own_parameters() const;
    /* The robot was sent something finer than what coarse steps tell: that is no less than the floor. */
    void look_at_command_steps();
    bool take_steps_as_sent();
    void fit_base();
    /* Behind a robot's free clock a slip that comes a tick apart is all that a stiff contact shows, and one tick is
     * what a late sensor looks like: the rows about slips are left out until all else is known. */
    bool is_behind_slips() const;
    void look_at_slips();

    /* Where the two tenths that are held out show far more or less of the error than the others, holds out two that
     * are more like the rest: a fit cannot find what acts where it does not look. Returns whether it did. */
    bool balance_parts();
    void find_what_is_left(); /* of the incumbent, by what it depends on */
    void rate_base(block_diagnosis &result);
    /* Rows that say something of their own. */
    std::size_t rows_under(const noise_model &noise) const;
    /* White sum of squares above the floor. */
    double excess(double cost, std::size_t rows) const;
    /* Far from the floor an error is no noise: colouring it would hide slow errors from the comparison. Near it, the
     * noise's own colour counts. */
    noise_model metric_for(const rig &rig);
    part_rms rms(block_model &model, row_use use) const;

    /* --- one effect more: block_acceptance.cpp --- */

    /* False: there is none. */
    bool find_next(block_diagnosis &result);
    /* A line in an error that is near the floor was there when the floor was measured: no noise, so no floor. */
    void doubt_floor();
    /* Candidates are compared under the noise that the best of them leaves. */
    void compare_anew(std::vector<candidate> &candidates);
    /* Where the candidate found better values for the parameters of before, it is compared with what these can do.
     */
    void fit_incumbent_from(const candidate &best);
    void drop_those_unseen(std::vector<candidate> &candidates);
    /* Whether a curve over the robot's position is clearly better than a polynomial of the fourth degree with the
     * base's parameters. */
    bool is_no_plain_curve(const candidate &one);
    /* How much better BIC and the white sum of squares say it is: where the error is smaller than the noise was
     * taken for, BIC alone boasts. */
    double improvement(const candidate &best, double bic_before) const;
    bool is_harmonic_of_motion(const candidate &one) const;
    /* Of the whole explainable error: what refines an effect may be small beside it, if it explains nearly all that
     * this has left, and so may what brings a linear robot down to the noise. */
    double share_of_all_asked(const candidate &best, double share, bool is_clear) const;
    bool is_worthwhile(const candidate &best, double better, double share, double of_all) const;
    double won_by_smoothing(const effect &best, const effect &other) const;
    bool leaves_nothing_that_depends(const candidate &best); /* on state or time */
    /* As it is measured: what is slow counts for little in the white sum of squares where the floor is as slow. */
    bool makes_error_larger(const candidate &best);
    /* Little beside the first effect may be its own finer way, unless, where there is a record with another command,
     * it proves itself clearly there: of a real servo its lag and dead time beside its velocity limit. */
    bool may_be_shown_by_unseen(const candidate &best, double better, double share, double of_all) const;
    bool accept(block_diagnosis &result, const std::vector<candidate> &candidates, const candidate &best,
                double bic_before, double explainable);

    /* --- what it explains on data that no fit has seen: block_gain.cpp --- */

    /* On the validation record or the parts held out. Behind a clock of its own without the rows of slips: one that
     * comes a tick apart is all that another record shows of what it rings in. */
    gain gain_on_unseen(const candidate &best);
    /* The same. Where these show it hardly, or in a moment only, they prove
     * nothing: then the record's odd parts are predicted from its even ones and the other way round. */
    gain gain_of(const candidate &best, bool may_act_in_one_stretch);

    /* The validation record, without regard to the noise's colour. */
    bool predicts_worse(const candidate &best);
    /* The validation record's error is far above the floor. */
    bool is_far_on_unseen(const rig &rig);

    /* The uses of the rows for a fit to one half of a record, and for one to the other. */
    using halves = std::array<std::vector<row_use>, 2>;
    gain crossed_gain(const candidate &best, const halves &held_out);
    halves halves_by_tenths() const;
    /* What acts in one stretch of the record only is in one half of the tenths only: parts in each of which the
     * candidate changes the replay by as much. */
    halves halves_where_it_acts(const candidate &best);
    /* Not in a few moments only, which our own precision may make up. */
    bool is_better_throughout(const candidate &one);

    /* --- the model goes on with it: block_adoption.cpp --- */

    void adopt(block_diagnosis &result, const candidate &best);
    /* No fit sees where a slip is that is held out: then two tenths without one are. Returns whether that changed.
     */
    bool hold_out_beside_slips();
    /* Where a fault that switches is upstream, its parameters make the error jump, and a fit with them gets stuck:
     * it begins where this block's own ones are best. */
    void fit_behind_switching();
    /* A line that a fit has left was taken for the noise's own colour, which then hides it from the next fit: once
     * the noise counts as white, and its colour is measured anew. */
    void fit_without_colour();
    /* An estimated floor of the manipulator under what is explained now, if that lies lower. */
    void renew_floor();
    /* The base was fitted to an error that has a cause now: where that led astray, the given values are the better
     * start. */
    void start_over_from_given();
    /* Beside what else was found, another minimum may be the lower one. */
    void start_over_from_other_scales();
    /* A fit stops at ripples of the error, and what is left of a wrong scale hides in the noise's colour: from
     * scales about the one found, nearer and nearer, with all rows alike. */
    void close_in_on_scale(const effect &known);
    /* An effect found first may have stood in for one found later. */
    void drop_stand_ins(block_diagnosis &result);
    /* The incumbent with that one switched off, and fitted so. */
    rig rig_without(const effect &dropped) const;
    fit_result fit_without(const effect &dropped);
    void fix_estimates(block_diagnosis &result) const;

    /* --- one for another: block_exchange.cpp --- */

    /* An effect found first may stand in the place of one that explains more beside what was found later: a
     * resonance in that of a longer dead time, before the lag. What explains as much is told. */
    void exchange_stand_ins(block_diagnosis &result);
    bool exchange_stand_in(block_diagnosis &result, std::size_t i); /* the i-th cause; whether it was one */
    /* Where to begin with an effect beside the `others` of the model: the best of its starts. */
    std::vector<rig> starts_beside(const rig &others, const ranked &known);
    /* That effect fitted beside the others. */
    fit_result fit_beside(const fit_result &others, const ranked &known);
    /* Those of any round that are not believed, the latest first, of which slopes mean something. */
    std::vector<const ranked *> others_weighed(const std::vector<ranked> &ranking) const;
    /* Of a model that is better than the incumbent by this. */
    double bic_better_by(double improvement) const;
    /* The best of those that were weighed in any round in the place of `known`; none: it is worse beyond doubt. */
    std::optional<candidate> rival_of(const effect &known, const std::vector<ranked> &ranking);
    /* The last one may stand in the place of two, of which neither by itself is better: a resonance in that of a lag
     * and a longer dead time. */
    void divide_stand_in(block_diagnosis &result);
    /* A cause of two parameters is no better than two of one each: a resonance that hardly swings is a lag and a
     * longer dead time to slow motion, and without reports the robot's lag and the sensor's. Where it is not the
     * only cause of the robot, one of the two is what it generalises. */
    bool may_be_two(const block_diagnosis &result);
    bool two_do_as_well_as(const effect &one, const block_diagnosis &result);
    /* Two more at once, of which neither is believed without the other beside what was found: dry friction that
     * differs between the directions is a constant force and a damping that differs. Of a manipulator, from its
     * equation of motion. */
    bool add_pair(block_diagnosis &result);
    /* The same of any block, where a first effect explains much but predicts nothing by itself, and a second one
     * beside it explains nearly all that is left: a limit behind a lag. */
    bool bring_in_two(block_diagnosis &result);
    bool starts_with(const ranked &first, block_diagnosis &result);
    /* Of two that were fitted together, each beside the other. */
    bool prove_each(std::array<cause, 2> &causes, candidate both, const std::array<const effect *, 2> &two);
    candidate best_regressed_pair(std::array<const effect *, 2> &two);
    /* On data that no fit has seen; the incumbent and the cause then have it. */
    bool prove_exchange(cause &known, const candidate &other);

    /* --- a grip that gives way beside another effect of the object: block_grip.cpp --- */

    /* That one shows while the object is held, the grip then beside it. */
    bool find_while_held(block_diagnosis &result);
    /* The best effects but the grip, from the rows alone in which it is held. */
    std::vector<candidate> candidates_while_held(const effect &grip);
    fit_result fit_base_here(); /* and the noise, to the rows in use alone */
    fit_result fit_grip_beside(const fit_result &while_held, const effect &grip);
    /* One that was found, and leaves more than noise, beside a base from the rows alone in which it is held. */
    void fit_grip_anew(const effect &grip);
    bool adopt_with_grip(block_diagnosis &result, const candidate &while_held, const effect &grip);

    /* --- what to say: block_verdict.cpp --- */

    void conclude(block_diagnosis &result);
    void judge(block_diagnosis &result);
    void write_up(block_diagnosis &result); /* of the incumbent, what the result then says of it */
    verdict verdict_of(block_diagnosis &result);
    /* How much the white sum of squares would fall if one of the causes acted otherwise early than late, far out
     * than in the middle of the way, fast than slow, or from a moment on: the most of all causes. And if a lateness
     * that grows were a low-pass'. */
    enum class form : std::size_t { over_time, over_way, with_velocity, at_once, as_low_pass, count };
    using forms = std::array<double, static_cast<std::size_t>(form::count)>;
    forms improved_by_other_forms();
    /* What a first-order lag that grows in place of the dead time would change of the error, one a row. */
    std::vector<double> change_by_growing_lag();
    struct remains {
        bool has_causes;
        bool has_thresholds; /* the causes' own, or of a fault upstream */
        bool has_bursts;
        bool are_only_moments; /* what causes, or one upstream, may leave in a few moments */
        double bad_moments;    /* share of half seconds with an error well above the floor */
        double share;          /* of the explainable error, as far as it depends on something */
        forms improved_by;
    };
    remains what_remains(const block_diagnosis &result);
    /* What speaks against a full explanation: each by itself makes `named` partly_explained, and a block without a
     * cause unknown. */
    struct doubt {
        std::string_view why;
        bool (block_search::*holds)(const remains &left);
    };
    static const doubt doubts[];
    /* A cause that is not beyond doubt gains less on unseen data than a floor that was found in the error itself is
     * uncertain by. */
    bool gains_hardly(const block_diagnosis &result) const;
    /* By more than any excuse is good for, whatever the other doubts say. */
    bool is_plainly_above(const remains &left);
    /* The robot's position, or the force, is noise about a constant, or as good as that: whatever of the library
     * holds it there is no cause. Withdraws what was found. */
    void withdraw_what_follows_nothing(block_diagnosis &result);
    /* Behind a robot's fault that switches, each instant that is off is an error in a stiff contact, and some cause
     * lowers it: one whose size may be none beside what is left is not told. */
    void withdraw_what_may_be_none(block_diagnosis &result);
    /* A sensor's gain beside another cause, without which all forces of the object scaled by it do as well: where a
     * grip gives way they decide the moments, and a fit finds only one of the two. */
    void withdraw_gain_of_scaled_object(block_diagnosis &result);
    /* Fits anew where the robot would be less late than its interpolation lets it be: no rig takes that. */
    void keep_dead_time_possible();
    /* All causes: back to the re-tuned base. */
    void withdraw(block_diagnosis &result);
    /* Its interval holds the size at which it does nothing. */
    bool may_be_none(const effect &known);
    bool follows_nothing(const remains &) { return follows_nothing_; }
    /* Beside the others, the size of a cause may be none. */
    bool holds_zero(const remains &left);
    /* A cause makes so much or so little of a body that it stands in for something else. */
    bool is_another_body(const remains &left);
    /* The object's second mode is where a robot with a cause resonates: what is not known of one looks like the
     * other. A robot at 69 Hz whose reports were noisy left the force a mode at 72. */
    bool is_mode_of_robot(const remains &left);
    /* Slow motion shows neither the sensor's lag or delay nor the damping that was found with it, d = k tau: an
     * object that relaxes, (k + d s + k1 tau s / (1 + tau s)) = (k + (d + k tau + k1 tau) s + d tau s2) / (1 + tau
     * s), is the same as a sensor's lag with another damping and mass. */
    bool is_late_and_damped(const remains &left);
    bool may_be_scaled_object(const remains &) { return may_be_scaled_object_; }
    bool shows_line(const remains &left);
    /* On the validation record the error is twice a measured floor, within all that the parameters are uncertain:
     * what fits one record does not predict another. */
    bool misses_unseen_record(const remains &left);
    /* The floor was found in the error itself, and this is slow: noise of that colour, or what nobody has explained;
     * only a standstill could tell. */
    bool may_hide_in_noise(const remains &left);
    bool are_only_events(const remains &left);
    bool follows_features(const remains &left);
    /* A re-tuned parameter would leave its tolerance if it could. */
    bool is_pressed(const remains &left);
    bool is_above_floor(const remains &left);
    bool has_suspect(const remains &left);
    /* The error's rows follow from those before it as no sensor's noise does, so that there is no floor to compare
     * with. */
    bool is_motion(const remains &left);
    /* Of a manipulator with further forces, what is left is no more of what they do than steps of the replay are off
     * by: they act as in the middle of a step, and dry friction catches between two. */
    bool is_of_our_steps(block_model &model) const;
    /* A good part of the explainable error is still there, and more than the floor is uncertain by. */
    bool leaves_much(const remains &left);
    bool is_late_in_stretches(const remains &left);
    /* What is put in for rows that are missing may be off by as much as a cause does. */
    bool rests_on_guesses(const remains &left);
    /* What is named may be what was before the parts of the record. */
    bool rings_on(const remains &) { return !found_.empty() && model_.rings_on(); }
    /* Beside dry friction, damping is at the lower end of its tolerance, or below. */
    bool may_fall_with_speed(const remains &left);
    /* A cause acts otherwise than it is modelled, see forms. */
    bool changes_over_time(const remains &left) { return acts_otherwise(left, form::over_time); }
    bool changes_over_way(const remains &left) { return acts_otherwise(left, form::over_way); }
    bool changes_with_velocity(const remains &left) { return acts_otherwise(left, form::with_velocity); }
    bool changes_at_once(const remains &left) { return acts_otherwise(left, form::at_once); }
    bool acts_as_low_pass(const remains &left) { return acts_otherwise(left, form::as_low_pass); }
    bool acts_otherwise(const remains &left, form of);
    /* A periodic error of less than one and a half periods, and a plain curve of the position does as well. */
    bool is_any_curve(const remains &left);
    /* Above a measured floor by more than that and the error itself are uncertain; without one: yes. */
    bool exceeds_uncertainty(double cost) const;
    /* Far above a floor that was found without it, and more than our own precision of what was explained. */
    bool exceeds_floor();
    bool exceeds_measured_floor() const;
    /* What is above the floor is no more than our own precision of what the causes explain. */
    bool is_within_instants();
    /* Where thresholds upstream switch at another moment than ours now and then, a stiff contact shows it: no cause
     * of its own, as long as it is little beside what the fault did. */
    bool is_rest_of_switching();
    /* All that is left may be the rounding of what was measured: it follows the motion, and proves nothing. */
    bool is_within_rounding();
    /* The same where coarse readings stand still for long: the rounding of each is one fact, of however many rows.
     */
    bool stands_within_its_step();
    /* The same of the command, where its column has coarser steps than the wire. */
    bool is_within_input_steps();
    /* Of the explainable error of the base. */
    double explainable(); /* what the error as re-tuned has above the floor: a white sum of squares */
    double share_left();
    /* Of the incumbent, over all rows. */
    std::vector<double> error_left();
    std::vector<double> white_error_left();

    /* --- what is fit to print: block_printed.cpp --- */

    /* Its interval holds the size at which it does nothing, of several values all of them. */
    bool has_no_size(const cause &told);
    /* `without`: the model without it, the other parameters fitted anew. */
    cause_evidence evidence_of(const cause &told, const rig &without);
    /* The last one first, each beside those that stay. Whether there was one: the verdict is then that of what
     * stays, and says so. */
    bool withdraw_what_is_not_printable(block_diagnosis &result);
    /* Where the error on the validation record is far above the noise, that is the first doubt, and the block counts
     * as not fully explained. */
    void admit_failure_on_unseen(block_diagnosis &result);
    /* Where the one cause leaves that much, those that predict the unseen data worse by less than it leaves. */
    void name_rivals_on_unseen(block_diagnosis &result);

    /* A delay of less than a row may be none at all, with what looks like it in its place: the lag of a drive. */
    void name_rivals_of_a_short_delay(block_diagnosis &result);
    double unseen_mean_square(const rig &rig);

    /* --- how well the parameters are known: block_intervals.cpp --- */

    void widen_by_our_steps();
    void widen_by_what_is_left();
    /* What the fit knows well enough for the blocks after this one to start from. */
    std::vector<free_parameter> refinable() const;

    const diagnosis_input &input_;
    const rig &given_;
    const events_of_records &events_;
    block_model model_;
    std::unique_ptr<block_model> unseen_; /* the validation record */
    noise_model noise_;
    noise_model metric_; /* what candidates are compared under */
    fit_result base_;
    rig retuned_; /* the base, as well as it was ever fitted: the search for causes shows it better values */
    fit_result incumbent_;
    leftover leftover_;
    double input_steps_rms_ = 0.0; /* what coarse steps of the column that drives it leave open of the output */
    bool has_floor_ = false;       /* measured, and to be believed */
    bool is_suspect_ = false;
    bool is_rest_ = false;
    bool follows_nothing_ = false;
    bool may_be_scaled_object_ = false;
    std::vector<const effect *> found_;
    std::vector<row_use> uses_with_slips_; /* behind slips */
};

} // namespace berth

#endif
