/* app_step after start: no heap, no page fault, no system call, no read of a clock. Each detector is first shown to
 * see what it is there for.
 *
 * Heap: every allocation of the process is counted, by hooks of the address sanitizer or by standing in for the C
 * library's functions. System calls: a child process that may only exit (a filter, not seccomp's strict mode, which
 * would allow read and write). Clock: the child faults when it reads the time-stamp counter, which a clock read
 * without a system call needs; x86 only. */
#include <doctest/doctest.h>

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <ctime>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "../../hal/rig/arm_file.h"
#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/arm/urdf.h"
#include "../support/sanitized.h"
#include "tick_builder.h"

namespace
{

volatile long allocations = 0;

} // namespace

#ifdef BERTH_SANITIZED

/* As in <sanitizer/allocator_interface.h>, which not every compiler package brings along. */
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void *, std::size_t),
                                                         void (*on_free)(const volatile void *));

namespace
{

constexpr bool has_sanitizer = true;

void count_allocation(const volatile void *, std::size_t)
{
    allocations = allocations + 1;
}

void count_release(const volatile void *)
{
    allocations = allocations + 1;
}

const int hooks_installed = __sanitizer_install_malloc_and_free_hooks(count_allocation, count_release);

} // namespace

#else

/* operator new, and what Eigen uses, end here too. A release counts as heap use as well. */
extern "C" {
void *__libc_malloc(std::size_t size);
void *__libc_calloc(std::size_t count, std::size_t size);
void *__libc_realloc(void *memory, std::size_t size);
void *__libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void *memory);

void *malloc(std::size_t size)
{
    allocations = allocations + 1;
    return __libc_malloc(size);
}

void *calloc(std::size_t count, std::size_t size)
{
    allocations = allocations + 1;
    return __libc_calloc(count, size);
}

void *realloc(void *memory, std::size_t size)
{
    allocations = allocations + 1;
    return __libc_realloc(memory, size);
}

void *aligned_alloc(std::size_t alignment, std::size_t size)
{
    allocations = allocations + 1;
    return __libc_memalign(alignment, size);
}

void *memalign(std::size_t alignment, std::size_t size)
{
    allocations = allocations + 1;
    return __libc_memalign(alignment, size);
}

int posix_memalign(void **memory, std::size_t alignment, std::size_t size)
{
    allocations = allocations + 1;
    *memory = __libc_memalign(alignment, size);
    return *memory != nullptr ? 0 : ENOMEM;
}

void free(void *memory)
{
    allocations = allocations + 1;
    __libc_free(memory);
}
}

namespace
{

constexpr bool has_sanitizer = false;
constexpr int hooks_installed = 1;

} // namespace

#endif

using namespace berth;

namespace
{

constexpr int warm_up_ticks = 500;
constexpr int counted_ticks = 10000;

/* Recorded inputs of a run that goes through every state but stopped, made before anything is counted. */
std::vector<tick_input> recorded_inputs(const app_config &config)
{
    bench::app_bench bench(config);
    std::vector<tick_input> inputs;
    inputs.reserve(warm_up_ticks + counted_ticks);
    for (int i = 0; i < warm_up_ticks + counted_ticks; i++) {
        const int phase = i % 2500;
        bench.request = phase < 100 ? OPERATOR_NONE : phase > 2300 ? OPERATOR_RESET : OPERATOR_RUN;
        bench.operator_position_m = phase > 800 ? 0.02 : 0.0;
        bench.force_N = phase > 1200 ? 40.0 : 0.0;
        bench.has_force = phase < 1400 || phase > 1500;
        bench.saturated = phase > 2000 && phase < 2100;
        bench.robot_fault = phase == 2200;
        bench.missed = phase == 50;
        bench.tick();
        inputs.push_back(bench.in());
    }
    return inputs;
}

/* An app that has been warmed up, and the inputs that come next. */
struct stepper {
    app_config config;
    std::vector<tick_input> inputs;
    std::unique_ptr<struct app> app = std::make_unique<struct app>();
    tick_output out{};
    unsigned states_seen = 0; /* set of supervisor states while counting */

    explicit stepper(const app_config &given) : config(given), inputs(recorded_inputs(given))
    {
        app_start(app.get(), &config);
        for (int i = 0; i < warm_up_ticks; i++) {
            app_step(app.get(), &inputs[static_cast<std::size_t>(i)], &out);
        }
    }

    void run()
    {
        for (std::size_t i = warm_up_ticks; i < inputs.size(); i++) {
            app_step(app.get(), &inputs[i], &out);
            states_seen |= 1u << app->supervisor.state;
        }
    }
};

struct named_config {
    const char *name;
    app_config config;
};

/* An arm in the manipulator's place. */
app_config with_arm(app_config config, const arm_config &arm, int integrator)
{
    config.arm = arm;
    config.arm.integrator = integrator;
    config.manipulator.direction_x = 1.0;
    return config;
}

/* Every integrator, with and without the inverse filter; arms in the plane and in space. */
std::vector<named_config> configs()
{
    app_config exact = bench::moving_config(), rk4 = exact, euler = exact;
    rk4.manipulator.integrator = INTEGRATOR_RK4;
    rk4.manipulator.substeps = 2;
    rk4.inverse_filter = {1, 12.0, 0.5, 40.0};
    euler.manipulator.integrator = INTEGRATOR_SEMI_IMPLICIT_EULER;
    const arm_config planar = load_arm("ess").config;
    const std::string urdf = "tests/arms/seven.urdf";
    arm_config spatial = arm_from_urdf(read_file(urdf), urdf, {"", "gripper", false}).config;
    for (int i = 0; i < spatial.joint_count; i++) {
        spatial.joints[i].initial_rad = 0.4 + 0.2 * i; /* away from singular poses */
    }
    return {{"exact", exact},
            {"rk4 and inverse filter", rk4},
            {"semi-implicit Euler", euler},
            {"planar arm, implicit midpoint", with_arm(exact, planar, ARM_IMPLICIT_MIDPOINT)},
            {"planar arm, rk4", with_arm(exact, planar, ARM_RK4)},
            {"spatial arm, implicit midpoint", with_arm(exact, spatial, ARM_IMPLICIT_MIDPOINT)}};
}

void check_went_through_states(const stepper &stepper)
{
    for (const supervisor_state state :
         {SUPERVISOR_READY, SUPERVISOR_RUNNING, SUPERVISOR_HOLDING, SUPERVISOR_FAULT}) {
        CAPTURE(std::string(supervisor_state_name(state)));
        CHECK((stepper.states_seen >> state & 1u) == 1u);
    }
}

template <class Work>
long allocations_in(Work work)
{
    const long before = allocations;
    work();
    return allocations - before;
}

template <class Work>
long page_faults_in(Work work)
{
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    work();
    getrusage(RUSAGE_SELF, &after);
    return after.ru_minflt - before.ru_minflt + after.ru_majflt - before.ru_majflt;
}

/* From here on the process may exit and do nothing else; 0 if that could not be had. */
bool forbid_system_calls()
{
    sock_filter program[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
    };
    const sock_fprog filter = {sizeof program / sizeof program[0], program};
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

constexpr int exit_worked = 42;
constexpr int exit_no_filter = 43;

enum class guard { system_calls, system_calls_and_clock, none };

/* Does the work in a child process under guard. How the child ended, as text: "done", or what killed it. */
template <class Work>
std::string in_guarded_child(guard guard, Work work)
{
    const pid_t child = fork();
    if (child == 0) {
        for (const int signal_number : {SIGSYS, SIGSEGV, SIGABRT}) {
            std::signal(signal_number, SIG_DFL); /* not the test framework's */
        }
        rlimit no_core{0, 0};
        setrlimit(RLIMIT_CORE, &no_core);
        if (guard == guard::none) {
            close(STDERR_FILENO);
        }
#ifdef __x86_64__
        if (guard == guard::system_calls_and_clock && prctl(PR_SET_TSC, PR_TSC_SIGSEGV, 0, 0, 0) != 0) {
            _exit(exit_no_filter);
        }
#endif
        if (guard != guard::none && !forbid_system_calls()) {
            _exit(exit_no_filter);
        }
        work();
        syscall(SYS_exit, exit_worked);
    }
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFSIGNALED(status)) {
        return std::string("killed by ") + sigabbrev_np(WTERMSIG(status));
    }
    return WEXITSTATUS(status) == exit_worked      ? "done"
           : WEXITSTATUS(status) == exit_no_filter ? "the guard could not be set up"
                                                   : "exit code " + std::to_string(WEXITSTATUS(status));
}

} // namespace

TEST_CASE("no_side_effects: the heap detector sees malloc, new, a growing vector, Eigen, and free")
{
    REQUIRE(hooks_installed > 0);
    void *volatile kept = nullptr;
    CHECK(allocations_in([&] { kept = std::malloc(1); }) == 1);
    CHECK(allocations_in([&] { std::free(kept); }) == 1);
    CHECK(allocations_in([&] { kept = std::aligned_alloc(64, 64); }) == 1);
    CHECK(allocations_in([&] { kept = std::realloc(kept, 1000); }) >= 1);
    std::free(kept);
    CHECK(allocations_in([&] { kept = ::operator new(8); }) == 1);
    CHECK(allocations_in([&] { ::operator delete(kept); }) == 1);
    std::vector<int> numbers;
    CHECK(allocations_in([&] { numbers.push_back(1); }) >= 1);
    Eigen::MatrixXd matrix;
    CHECK(allocations_in([&] { matrix.resize(3, 3); }) >= 1);
    CHECK(allocations_in([] {}) == 0);
}

TEST_CASE("no_side_effects: app_step does not use the heap")
{
    for (const named_config &row : configs()) {
        CAPTURE(std::string(row.name));
        stepper stepper(row.config);
        Eigen::internal::set_is_malloc_allowed(false);
        const long count = allocations_in([&] { stepper.run(); });
        Eigen::internal::set_is_malloc_allowed(true);
        CHECK(count == 0);
        check_went_through_states(stepper);
    }
}

TEST_CASE("no_side_effects: Eigen's own guard ends a process that lets it allocate")
{
    CHECK(in_guarded_child(guard::none, [] {
              Eigen::internal::set_is_malloc_allowed(false);
              const Eigen::MatrixXd matrix(3, 3);
          }) == "killed by ABRT");
}

TEST_CASE("no_side_effects: the page fault detector sees a page touched for the first time")
{
    const auto page_bytes = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    void *page = mmap(nullptr, page_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    REQUIRE(page != MAP_FAILED);
    CHECK(page_faults_in([&] { *static_cast<volatile char *>(page) = 1; }) >= 1); /* a sanitizer's shadow: 1 more */
    CHECK(page_faults_in([&] { *static_cast<volatile char *>(page) = 2; }) == 0);
    munmap(page, page_bytes);
}

TEST_CASE("no_side_effects: app_step causes no page fault")
{
    for (const named_config &row : configs()) {
        CAPTURE(std::string(row.name));
        stepper stepper(row.config);
        CHECK(page_faults_in([&] { stepper.run(); }) == 0);
    }
}

TEST_CASE("no_side_effects: the system call detector sees a write, the clock detector a read of the clock")
{
    CHECK(in_guarded_child(guard::system_calls_and_clock, [] {}) == "done");
    CHECK(in_guarded_child(guard::system_calls, [] { syscall(SYS_write, STDERR_FILENO, "", 0); }) ==
          "killed by SYS");
    CHECK(in_guarded_child(guard::system_calls, [] { syscall(SYS_getpid); }) == "killed by SYS");
#ifdef __x86_64__
    timespec now{};
    const std::string end =
        in_guarded_child(guard::system_calls_and_clock, [&] { clock_gettime(CLOCK_MONOTONIC, &now); });
    const bool is_seen = end == "killed by SEGV" || end == "killed by SYS"; /* SYS: a clock that needs the kernel */
    CAPTURE(end);
    CHECK(is_seen);
#endif
}

TEST_CASE("no_side_effects: app_step makes no system call and reads no clock")
{
    for (const named_config &row : configs()) {
        CAPTURE(std::string(row.name));
        stepper stepper(row.config);
        CHECK(in_guarded_child(guard::system_calls_and_clock, [&] { stepper.run(); }) == "done");
    }
#ifndef __x86_64__
    MESSAGE("not an x86 machine: a clock read without a system call would not be seen here");
#endif
}

TEST_CASE("no_side_effects: the same inputs give the same outputs, bit for bit")
{
    for (const named_config &row : configs()) {
        CAPTURE(std::string(row.name));
        stepper first(row.config), second(row.config);
        int differing = 0;
        for (std::size_t i = warm_up_ticks; i < first.inputs.size(); i++) {
            app_step(first.app.get(), &first.inputs[i], &first.out);
            app_step(second.app.get(), &second.inputs[i], &second.out);
            const recorder &a = first.app->recorder, &b = second.app->recorder;
            differing += a.size_bytes != b.size_bytes || std::memcmp(a.bytes, b.bytes, a.size_bytes) != 0;
        }
        CHECK(differing == 0);
    }
    if (has_sanitizer) {
        MESSAGE(
            "built with sanitizers: what is counted is the instrumented code, allocations by the sanitizer's hooks");
    }
}
