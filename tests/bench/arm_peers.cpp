/* Times what others take for the arm of a URDF file: Pinocchio's articulated-body algorithm, and MuJoCo's step.
 *
 *   arm_peers URDF planar|spatial SAMPLES     a JSON object, as of arm_bench
 *
 * A program by itself: the library of Pinocchio's package is built with Eigen's vectors, ours without. */
#include <cstdlib>

#include <mujoco/mujoco.h>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/multibody.hpp>
#include <pinocchio/parsers/urdf.hpp>

#include "timed.h"

namespace
{

/* Behind each joint a rotor on the satellite that turns about its own axis, on a servo's spring and damper; a tendon
 * from one to the other is the joint's elasticity: what our step carries. */
void add_motors(mjSpec *spec, mjsBody *root)
{
    std::vector<std::string> joints;
    for (mjsElement *at = mjs_firstElement(spec, mjOBJ_JOINT); at != nullptr; at = mjs_nextElement(spec, at)) {
        if (mjs_asJoint(at)->type == mjJNT_HINGE) {
            joints.emplace_back(mjs_getString(mjs_getName(at)));
        }
    }
    for (const std::string &joint : joints) {
        const std::string motor = "motor_" + joint;
        mjsBody *rotor = mjs_addBody(root, nullptr);
        rotor->mass = 1e-3;
        rotor->inertia[0] = rotor->inertia[1] = rotor->inertia[2] = 1.0;
        rotor->explicitinertial = 1;
        mjsJoint *turning = mjs_addJoint(rotor, nullptr);
        mjs_setName(turning->element, motor.c_str());
        turning->type = mjJNT_HINGE;
        mjsTendon *spring = mjs_addTendon(spec, nullptr);
        mjs_wrapJoint(spring, joint.c_str(), -1.0);
        mjs_wrapJoint(spring, motor.c_str(), 1.0);
        spring->stiffness[0] = 1e4;
        spring->damping[0] = 10.0;
        spring->springlength[0] = spring->springlength[1] = 0.0;
    }
}

/* The same arm in MuJoCo, its joints on springs and dampers to the body before, or to motors. */
mjModel *mujoco_model(const std::string &urdf, bool has_motors)
{
    char error[1000] = "";
    mjSpec *spec = mj_parseXML(urdf.c_str(), nullptr, error, sizeof error);
    if (spec == nullptr) {
        std::fprintf(stderr, "arm_peers: %s\n", error);
        std::exit(2);
    }
    spec->compiler.fusestatic = 1;
    spec->option.timestep = 2.5e-3;
    spec->option.gravity[2] = 0.0;
    spec->option.integrator = mjINT_IMPLICITFAST;
    mjsBody *root = mjs_asBody(mjs_firstChild(mjs_findBody(spec, "world"), mjOBJ_BODY, 0));
    if (has_motors) {
        add_motors(spec, root);
    }
    mjs_addFreeJoint(root);
    mjModel *model = mj_compile(spec, nullptr);
    if (model == nullptr) {
        std::fprintf(stderr, "arm_peers: %s\n", mjs_getError(spec));
        std::exit(2);
    }
    for (int joint = 1; joint < model->njnt; joint++) {
        model->jnt_limited[joint] = 0;
        const bool is_held =
            !has_motors || std::string(mj_id2name(model, mjOBJ_JOINT, joint)).rfind("motor_", 0) == 0;
        model->jnt_stiffness[joint] = is_held ? 100.0 : 0.0;
        model->dof_damping[model->jnt_dofadr[joint]] = is_held ? 10.0 : 0.0;
    }
    mj_deleteSpec(spec);
    return model;
}

} // namespace

int main(int argc, char **argv)
{
    if (argc != 4) {
        std::fprintf(stderr, "usage: arm_peers URDF planar|spatial SAMPLES\n");
        return 2;
    }
    pinocchio::Model model;
    if (std::string(argv[2]) == "planar") {
        pinocchio::urdf::buildModel(argv[1], pinocchio::JointModelPlanar(), model);
    } else {
        pinocchio::urdf::buildModel(argv[1], pinocchio::JointModelFreeFlyer(), model);
    }
    pinocchio::Data data(model);
    const Eigen::VectorXd q = pinocchio::neutral(model);
    const Eigen::VectorXd v = Eigen::VectorXd::Constant(model.nv, 0.1);
    const Eigen::VectorXd torque = Eigen::VectorXd::Constant(model.nv, 1.0);
    mjModel *const other = mujoco_model(argv[1], false);
    mjModel *const with_motors = mujoco_model(argv[1], true);
    mjData *const other_data = mj_makeData(other);
    mjData *const motors_data = mj_makeData(with_motors);
    timed aba{"pinocchio_aba"};
    timed mujoco{"mujoco_step"};
    timed mujoco_motors{"mujoco_step_with_motors"};
    volatile double kept = 0.0;
    const auto samples = static_cast<std::size_t>(std::strtol(argv[3], nullptr, 10));
    const auto start = [](const mjModel *of, mjData *data) {
        mj_resetData(of, data);
        std::fill(data->qvel, data->qvel + of->nv, 0.05);
    };
    for (int pass = 0; pass < passes; pass++) {
        start(other, other_data);
        start(with_motors, motors_data);
        for (std::size_t i = 0; i < samples; i++) {
            aba.once(i, [&] { kept = pinocchio::aba(model, data, q, v, torque)(0); });
            mujoco.once(i, [&] { mj_step(other, other_data); });
            mujoco_motors.once(i, [&] { mj_step(with_motors, motors_data); });
        }
    }
    (void)kept;
    print_timed({&aba, &mujoco, &mujoco_motors});
    for (mjData *const one : {other_data, motors_data}) {
        mj_deleteData(one);
    }
    for (mjModel *const one : {other, with_motors}) {
        mj_deleteModel(one);
    }
    return 0;
}
