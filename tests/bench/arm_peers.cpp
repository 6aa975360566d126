/* Times what others take for the arm of a URDF file: Pinocchio's articulated-body algorithm, and MuJoCo's step.
 *
 *   arm_peers URDF planar|spatial SAMPLES     a JSON object: ns, median and p99.9, in turns
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

/* The same arm in MuJoCo, its joints on springs and dampers instead of motors. */
mjModel *mujoco_model(const std::string &urdf)
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
    mjs_addFreeJoint(root);
    mjModel *model = mj_compile(spec, nullptr);
    if (model == nullptr) {
        std::fprintf(stderr, "arm_peers: %s\n", mjs_getError(spec));
        std::exit(2);
    }
    for (int joint = 1; joint < model->njnt; joint++) {
        model->jnt_limited[joint] = 0;
        model->jnt_stiffness[joint] = 100.0;
        model->dof_damping[model->jnt_dofadr[joint]] = 10.0;
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
    mjModel *const other = mujoco_model(argv[1]);
    mjData *const other_data = mj_makeData(other);
    timed aba{"pinocchio_aba", {}};
    timed mujoco{"mujoco_step", {}};
    volatile double kept = 0.0;
    for (long i = std::strtol(argv[3], nullptr, 10); i > 0; i--) {
        aba.once([&] { kept = pinocchio::aba(model, data, q, v, torque)(0); });
        mujoco.once([&] { mj_step(other, other_data); });
    }
    (void)kept;
    print_timed({&aba, &mujoco});
    mj_deleteData(other_data);
    mj_deleteModel(other);
    return 0;
}
