/* The host library: a rig goes in, answers come out as plain structures. The command, reports and other languages
 * are its clients; none of them reads printed text.
 *
 *   rig        load_rig(), parse_rig(), print_config(); refuse_unstated() for what must not be assumed
 *   budget     delay_budget_of(): where the loop's delay comes from, in ms
 *   assumed    assumptions_of(): what decides and was not stated
 *   spectrum   loop_spectrum(): eigenvalues of one period; predict_growth(): the growth that they say, in 1/s
 *   schedule   worst_of_schedule(): the loop that decides where a rig file schedules a change
 *   amplitude  predictor_at(): of a loop whose effects depend on the size of its motion
 *   answer     answer_of(): prediction, advice and margin of a rig, the same for every command
 *   limits     limits_of(): how far each parameter may go; advise(): the smallest change that makes a loop stable
 *   bounce     play_bounce(): restitution of a tool in contact; find_bounce_limit(): where it gains energy
 *   compensated  growth_of_compensated(), limits_of_compensated(): of loops with compensation of the dead time
 *   compensation  choose_compensation(), recommend(): which method suits a rig
 *   varied     growth_of_varied(): of many rigs that differ from one in a few keys, for campaigns
 *   map        stability_map.h: largest |z| over two parameters
 *   run        play(): firmware and simulated rig in virtual time; motion_recorder takes a run's ticks;
 * motion_evidence is what they show; answer_of_run(): what motion and model say together verdict    judge(): one
 * verdict from prediction and motion, its words and its advice
 *
 * Everything that is wrong with a rig comes as input_error, with file, line, key and remedy. Sources of the
 * mathematics stand in the headers of stability/. */
#ifndef SIM_HAL_BERTH_H
#define SIM_HAL_BERTH_H

#include "../hal/rig/given.h"
#include "../hal/rig/rig_file.h"
#include "advice.h"
#include "answer.h"
#include "assumptions.h"
#include "bounce.h"
#include "compensated.h"
#include "delay_budget.h"
#include "loop_at_amplitude.h"
#include "motion.h"
#include "prediction.h"
#include "recommendation.h"
#include "rig_limits.h"
#include "run_answer.h"
#include "schedule.h"
#include "stability/limits.h"
#include "stability/spectrum.h"
#include "stability/stability_map.h"
#include "varied_rigs.h"
#include "verdict.h"

#endif
