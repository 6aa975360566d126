#include "zero_count.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "../../firmware/pi.h"

namespace berth
{

namespace
{

/* Between neighbouring samples B/A turns and grows by at most this, in rad and nepers ... */
constexpr double change_max = 0.7;

/* ... unless they are this near, in rad: a zero of A or B on the circle itself. */
constexpr double step_least = 1e-12;

constexpr int first_steps = 48;

/* A walk takes some hundred steps. Where it takes more, neighbours differ by rounding, and smaller steps show no
 * more: from there on none is smaller than this share of its angle. */
constexpr int steps_max = 4000;
constexpr double share_of_rounding = 0.01;

/* One point of the upper half of the circle. */
struct sample {
    double angle;
    std::complex<double> ratio; /* B / A */
    double loss;                /* -ln |L|, L = w^delay B/A */
    double loss_slope;          /* by angle */
    double phase;               /* arg L, continued from sample to sample */
};

double wrapped(double phase)
{
    return phase - 2.0 * pi * std::round(phase / (2.0 * pi));
}

class walk
{
  public:
    walk(const loop_equation &equation, double radius, std::vector<std::complex<double>> *starts)
        : equation_(equation), radius_(radius), delay_gain_(equation.delay * std::log(radius)), starts_(starts)
    {
    }

    /* Change of arg(1 + L) over the half circle, in rad. */
    double turn()
    {
        std::vector<double> stops{pi};
        for (int i = 1; i < first_steps; i++) {
            stops.push_back(pi * i / first_steps);
        }
        for (int i = 0; i < equation_.a_factor_count; i++) {
            for (const auto root : roots_of(equation_.a_factors[static_cast<std::size_t>(i)])) {
                const double angle = std::abs(std::arg(root));
                if (angle > 0.0 && angle < pi) {
                    stops.push_back(angle);
                }
            }
        }
        std::sort(stops.begin(), stops.end());
        sample from = at(0.0);
        from.phase = std::arg(from.ratio);
        double sum = 0.0;
        for (const double stop : stops) {
            sum += turn_to(from, stop);
            if (std::isnan(sum)) {
                break;
            }
        }
        return sum;
    }

  private:
    sample at(double angle) const
    {
        const std::complex<double> w = std::polar(radius_, angle);
        const equation_parts parts = evaluate_parts(equation_, w);
        const std::complex<double> ratio = parts.b / parts.a;
        const std::complex<double> log_slope = w * (parts.b_slope / parts.b - parts.a_slope / parts.a);
        return {angle, ratio, -delay_gain_ - 0.5 * std::log(std::norm(ratio)), log_slope.imag(), 0.0};
    }

    /* From `from` to `angle`, in steps over which B/A changes little. */
    double turn_to(sample &from, double angle)
    {
        double sum = 0.0;
        double step = angle - from.angle;
        while (from.angle < angle) {
            const double next = step < angle - from.angle ? from.angle + step : angle;
            sample to = at(next);
            const bool has_slope = std::isfinite(to.loss_slope) || std::norm(to.ratio) == 0.0;
            if (std::isnan(std::norm(to.ratio)) || !has_slope) {
                return std::numeric_limits<double>::quiet_NaN();
            }
            const double turned = std::arg(to.ratio * std::conj(from.ratio));
            /* A zero of B on the circle, as a free object has at w = 1, has no phase to go on from. */
            const bool is_from_zero = std::norm(from.ratio) == 0.0;
            to.phase = is_from_zero ? std::arg(to.ratio) + equation_.delay * next
                                    : from.phase + turned + equation_.delay * (next - from.angle);
            steps_++;
            const double least = steps_ < steps_max ? step_least : std::max(step_least, share_of_rounding * next);
            if ((std::abs(turned) > change_max || !(std::abs(to.loss - from.loss) < change_max) ||
                 (may_oppose(from, to) && !is_straight(from, to))) &&
                next - from.angle > least) {
                step = 0.5 * (next - from.angle);
                continue;
            }
            sum += turn_between(from, to);
            step = 2.0 * (next - from.angle);
            from = to;
        }
        return sum;
    }

    /* L may point to -1 between the samples. Where it does not, 1 + L turns the same whether |L| passes 1 or not. */
    static bool may_oppose(const sample &from, const sample &to)
    {
        const double low = std::min(from.phase, to.phase) - change_max;
        const double high = std::max(from.phase, to.phase) + change_max;
        return first_opposed(low) <= high;
    }

    /* The first odd multiple of pi that is no less. */
    static double first_opposed(double phase) { return (2.0 * std::ceil((phase / pi - 1.0) / 2.0) + 1.0) * pi; }

    /* ln |L| goes straight enough that it has at most one zero between the samples: it is out of reach, or slopes
     * and secant agree. */
    static bool is_straight(const sample &from, const sample &to)
    {
        const double width = to.angle - from.angle;
        const double secant = (to.loss - from.loss) / width;
        const double steepest = std::max({std::abs(from.loss_slope), std::abs(to.loss_slope), std::abs(secant)});
        if (from.loss * to.loss > 0.0 && std::min(std::abs(from.loss), std::abs(to.loss)) > 2.0 * width * steepest) {
            return true;
        }
        const auto agrees = [&](double slope) {
            return slope * secant > 0.0 && std::abs(slope) < 3.0 * std::abs(secant) &&
                   std::abs(secant) < 3.0 * std::abs(slope);
        };
        return agrees(from.loss_slope) && agrees(to.loss_slope);
    }

    /* Where |L| < 1, 1 + L stays in the right half plane; where |L| > 1, so does 1 + 1/L = (1 + L)/L. */
    double turn_between(const sample &from, const sample &to)
    {
        if (from.loss > 0.0 && to.loss > 0.0) {
            return arg_of_sum(to) - arg_of_sum(from);
        }
        if (from.loss <= 0.0 && to.loss <= 0.0) {
            note_starts(from, to);
            return (to.phase - from.phase) + arg_of_inverse_sum(to) - arg_of_inverse_sum(from);
        }
        const sample middle = crossing(from, to);
        const double half = 0.5 * wrapped(middle.phase); /* arg(1 + L) where |L| = 1 */
        if (from.loss > 0.0) {
            note_starts(middle, to);
            return (half - arg_of_sum(from)) + (to.phase - middle.phase) + arg_of_inverse_sum(to) + half;
        }
        note_starts(from, middle);
        return (middle.phase - from.phase) - half - arg_of_inverse_sum(from) + arg_of_sum(to) - half;
    }

    static double arg_of_sum(const sample &s) { return std::arg(1.0 + std::polar(std::exp(-s.loss), s.phase)); }
    static double arg_of_inverse_sum(const sample &s)
    {
        return std::arg(1.0 + std::polar(std::exp(s.loss), -s.phase));
    }

    /* The point between two samples where |L| = 1: Newton's method, bisection where it leaves the bracket. */
    sample crossing(sample from, sample to) const
    {
        sample middle = std::abs(from.loss) < std::abs(to.loss) ? from : to;
        for (int i = 0; i < 60 && std::abs(middle.loss) > 1e-13; i++) {
            double angle = middle.angle - middle.loss / middle.loss_slope;
            if (!(angle > from.angle && angle < to.angle)) {
                angle = 0.5 * (from.angle + to.angle);
            }
            middle = at(angle);
            middle.phase =
                from.phase + std::arg(middle.ratio * std::conj(from.ratio)) + equation_.delay * (angle - from.angle);
            ((middle.loss > 0.0) == (from.loss > 0.0) ? from : to) = middle;
        }
        return middle;
    }

    /* Every turn of L through -1's direction outside the unit circle belongs to a zero. */
    void note_starts(const sample &from, const sample &to)
    {
        if (starts_ == nullptr) {
            return;
        }
        const double low = std::min(from.phase, to.phase);
        const double high = std::max(from.phase, to.phase);
        double opposed = first_opposed(low);
        while (opposed <= high) {
            const double share = high > low ? (opposed - from.phase) / (to.phase - from.phase) : 0.0;
            starts_->push_back(std::polar(radius_, from.angle + share * (to.angle - from.angle)));
            opposed += 2.0 * pi;
        }
    }

    const loop_equation &equation_;
    double radius_;
    double delay_gain_;
    std::vector<std::complex<double>> *starts_;
    int steps_ = 0;
};

/* The next smaller circle that keeps off the zeros of A: on one of them, L has no phase. */
double off_the_poles(const loop_equation &equation, double radius)
{
    for (bool moved = true; moved;) {
        moved = false;
        for (int i = 0; i < equation.a_factor_count; i++) {
            for (const auto root : roots_of(equation.a_factors[static_cast<std::size_t>(i)])) {
                if (std::abs(std::abs(root) - radius) < 0.9 * count_margin * radius) {
                    radius = std::abs(root) * (1.0 - count_margin);
                    moved = true;
                }
            }
        }
    }
    return radius;
}

} // namespace

int count_zeros_inside(const loop_equation &equation, double radius, std::vector<std::complex<double>> *starts)
{
    radius = off_the_poles(equation, radius);
    const auto &b = equation.b_rest.coefficients;
    const bool feeds_back = std::any_of(b.begin(), b.end(), [](double c) { return c != 0.0; });
    const double turned = feeds_back ? walk(equation, radius, starts).turn() : 0.0;
    if (std::isnan(turned)) {
        return equation.degree(); /* numbers have overflowed: no loop that could be stable */
    }
    int zeros_of_a = 0;
    for (int i = 0; i < equation.a_factor_count; i++) {
        for (const auto root : roots_of(equation.a_factors[static_cast<std::size_t>(i)])) {
            zeros_of_a += std::norm(root) < radius * radius ? 1 : 0;
        }
    }
    return zeros_of_a + static_cast<int>(std::lround(turned / pi));
}

} // namespace berth
