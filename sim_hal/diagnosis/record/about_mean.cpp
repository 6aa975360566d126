#include "about_mean.h"

#include <cmath>

namespace berth
{

double rms_about_mean(const block_model &model)
{
    const std::vector<double> &output = model.measured();
    double mean = 0.0;
    double rows = 0.0;
    double square = 0.0;
    for (std::size_t n = 0; n < output.size(); n++) {
        if (model.uses()[n] == row_use::fit) {
            rows += 1.0;
            const double off = output[n] - mean;
            mean += off / rows;
            square += off * (output[n] - mean);
        }
    }
    return rows > 0.0 ? std::sqrt(square / rows) : 0.0;
}

} // namespace berth
