/* How much a diagnosis may work: processor time of this program, and what was left out as it was over. */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_WORK_LIMIT_H
#define SIM_HAL_DIAGNOSIS_SEARCH_WORK_LIMIT_H

#include <ctime>
#include <set>
#include <string>
#include <string_view>

namespace berth
{

class work_limit
{
  public:
    /* A minute of record is worth a minute of work. */
    static double usual_s(double record_s) { return record_s > 60.0 ? record_s : 60.0; }

    /* From now on. `processor_s`: infinite for none. */
    explicit work_limit(double processor_s) : begin_(std::clock()), processor_s_(processor_s) {}

    double processor_s() const { return processor_s_; }
    bool is_over() const
    {
        return static_cast<double>(std::clock() - begin_) > processor_s_ * static_cast<double>(CLOCKS_PER_SEC);
    }

    /* Effects that are not tried, or not once more beside others. */
    void leave_out(std::string_view effect) { left_out_.emplace(effect); }
    const std::set<std::string> &left_out() const { return left_out_; }

  private:
    std::clock_t begin_;
    double processor_s_;
    std::set<std::string> left_out_;
};

} // namespace berth

#endif
