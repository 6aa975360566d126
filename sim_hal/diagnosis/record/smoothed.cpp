#include "smoothed.h"

#include <algorithm>
#include <cmath>

namespace berth
{

namespace
{

/* Position and velocity, and their covariance. */
struct state {
    double x = 0.0, v = 0.0;
    double xx = 0.0, xv = 0.0, vv = 0.0;
};

/* A row later, with accelerations of this density (m2/s3) in between. */
state predicted(const state &s, double period_s, double density)
{
    const double t = period_s;
    return {s.x + t * s.v, s.v, s.xx + t * (2.0 * s.xv + t * s.vv) + density * t * t * t / 3.0,
            s.xv + t * s.vv + density * t * t / 2.0, s.vv + density * t};
}

class smoother
{
  public:
    smoother(const double *measured, std::size_t rows, double period_s, double noise)
        : measured_(measured), rows_(rows), period_s_(period_s), variance_(noise * noise), before_(rows),
          after_(rows)
    {
    }

    /* With the densities of each row; returns the logarithm of the likelihood. */
    double filter(const std::vector<double> &density)
    {
        double likelihood = 0.0;
        const double way = (measured_[1] - measured_[0]) / period_s_;
        const double uncertain = way * way + variance_ / (period_s_ * period_s_);
        for (std::size_t n = 0; n < rows_; n++) {
            before_[n] = n == 0 ? state{measured_[0], 0.0, variance_, 0.0, uncertain}
                                : predicted(after_[n - 1], period_s_, density[n]);
            const state &b = before_[n];
            const double all = b.xx + variance_;
            const double news = measured_[n] - b.x;
            likelihood -= 0.5 * (std::log(all) + news * news / all);
            const double kept = variance_ / all;
            after_[n] = {b.x + b.xx / all * news, b.v + b.xv / all * news, b.xx * kept, b.xv * kept,
                         b.vv - b.xv * b.xv / all};
        }
        return likelihood;
    }

    /* Of the last filter(): positions and velocities from all rows. */
    void pass_back(std::vector<double> &x, std::vector<double> &v) const
    {
        x.assign(rows_, after_.back().x);
        v.assign(rows_, after_.back().v);
        for (std::size_t n = rows_ - 1; n-- > 0;) {
            const state &a = after_[n];
            const state &b = before_[n + 1];
            /* Covariance of this row with the next one, over that of the next. */
            const double x_x = a.xx + period_s_ * a.xv;
            const double v_x = a.xv + period_s_ * a.vv;
            const double determinant = b.xx * b.vv - b.xv * b.xv;
            const double off_x = x[n + 1] - b.x;
            const double off_v = v[n + 1] - b.v;
            const double by_x = (b.vv * off_x - b.xv * off_v) / determinant;
            const double by_v = (b.xx * off_v - b.xv * off_x) / determinant;
            x[n] = a.x + x_x * by_x + a.xv * by_v;
            v[n] = a.v + v_x * by_x + a.vv * by_v;
        }
    }

  private:
    const double *measured_;
    std::size_t rows_;
    double period_s_;
    double variance_;
    std::vector<state> before_;
    std::vector<state> after_;
};

/* The density that is likeliest for all rows alike. */
double likeliest_density(smoother &rows, std::size_t count, double period_s, double noise)
{
    constexpr double step = 4.0;
    constexpr int steps = 35;                                             /* 4^35: 21 decades, from 1e-12 to 1e9 */
    const double unit = noise * noise / (period_s * period_s * period_s); /* moves as much in a row as the noise */
    double best = unit;
    double most = -1e300;
    for (int n = 0; n < steps; n++) {
        const double density = 1e-12 * unit * std::pow(step, n);
        const double likelihood = rows.filter(std::vector<double>(count, density));
        if (likelihood > most) {
            most = likelihood;
            best = density;
        }
    }
    return best;
}

/* Mean of the squared accelerations of the rows about each. */
std::vector<double> densities_about(const std::vector<double> &v, double period_s, double least)
{
    constexpr std::size_t about = 25; /* rows on each side: enough for a variance to a fifth */
    std::vector<double> sums(v.size(), 0.0);
    for (std::size_t n = 1; n < v.size(); n++) {
        const double a = (v[n] - v[n - 1]) / period_s;
        sums[n] = sums[n - 1] + a * a;
    }
    std::vector<double> densities(v.size(), least);
    for (std::size_t n = 0; n < v.size(); n++) {
        const std::size_t from = n > about ? n - about : 0;
        const std::size_t to = std::min(v.size() - 1, n + about);
        const double mean = to > from ? (sums[to] - sums[from]) / static_cast<double>(to - from) : 0.0;
        densities[n] = std::max(least, mean * period_s);
    }
    return densities;
}

void smooth(std::vector<double> &made, const record_segment &part, double period_s, double noise)
{
    constexpr int rounds = 4;      /* the densities stand after three */
    constexpr double least = 1e-6; /* of the likeliest density: what rests, rests */
    const std::size_t count = part.end - part.begin;
    if (count < 4) {
        return;
    }
    const std::vector<double> measured(made.begin() + static_cast<std::ptrdiff_t>(part.begin),
                                       made.begin() + static_cast<std::ptrdiff_t>(part.end));
    smoother rows(measured.data(), count, period_s, noise);
    const double likeliest = likeliest_density(rows, count, period_s, noise);
    std::vector<double> densities(count, likeliest);
    std::vector<double> x;
    std::vector<double> v;
    for (int round = 0; round < rounds; round++) {
        rows.filter(densities);
        rows.pass_back(x, v);
        densities = densities_about(v, period_s, least * likeliest);
    }
    for (std::size_t n = 0; n < count; n++) {
        made[part.begin + n] = std::isfinite(x[n]) ? x[n] : measured[n];
    }
}

} // namespace

std::vector<double> smoothed(const record &data, const std::vector<double> &column, double noise)
{
    std::vector<double> made = column;
    for (const record_segment &part : data.segments) {
        if (noise > 0.0) {
            smooth(made, part, data.period_s, noise);
        }
    }
    return made;
}

} // namespace berth
