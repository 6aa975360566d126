#include "sections.h"

namespace berth
{

const std::vector<section_meaning> &section_meanings()
{
    static const std::vector<section_meaning> meanings = {
        {"run", "the simulated run: length, seed and events"},
        {"loop", "the real-time loop: rate and missed ticks"},
        {"reflex", "when the loop stops by itself"},
        {"feedback", "how much of the measured force the manipulator feels"},
        {"manipulator", "the numerical substructure: the simulated manipulator"},
        {"operator", "the operator's commands: interface and limits"},
        {"profile", "what the operator commands"},
        {"energy", "the energy account"},
        {"sensor_channel", "how the loop receives forces"},
        {"robot_channel", "how the loop talks to the robot"},
        {"cia402", "a CiA 402 drive on CANopen, with robot_channel.profile = \"cia402\""},
        {"limits", "limits of the setpoints that are sent to the robot"},
        {"inverse_filter", "compensation of the robot's amplitude error"},
        {"robot", "the robot: dead time and behaviour"},
        {"sensor", "the force sensor: stiffness, low-pass, delay and errors"},
        {"tare", "the sensor's zero"},
        {"tool", "the tool that hangs on the sensor, and weighs"},
        {"object", "the physical substructure: the object that the robot meets"},
        {"bus", "the CAN buses of robot and sensor"},
        {"extrapolation", "compensation of the dead time: extrapolated setpoints"},
        {"adaptive_inverse", "compensation of the dead time: an inverse of the robot, fitted while the loop runs"},
        {"force_lead", "compensation of the dead time: the force, led by a model of the object"},
        {"prediction", "compensation of the dead time: a model of the object beside the loop"},
        {"identification", "the object's model, identified while the loop runs"},
        {"passivity", "a passivity controller"},
        {"dissipation", "a damper that is always there"},
        {"solver", "the solver of the simulated rig"},
        {"target", "wiring of the real machine; a simulated rig does not use it"},
        {"axis", "the hardware on the robot's further axes, with a whole arm"},
        {"wrench", "how a force and torque sensor is mounted, and its crosstalk"},
        {"orders", "what the operator orders an arm to do, and when"},
        {"signals", "where a record of another program keeps its signals"},
        {"tolerances", "how far a value may be off, as a share of it"},
    };
    return meanings;
}

} // namespace berth
