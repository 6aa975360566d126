/* What has to be there for a hal to meet a rig: nothing where the rig is simulated behind it, the simulated rig on
 * other interfaces where the buses are real. */
#ifndef TESTS_SUPPORT_FAR_SIDE_H
#define TESTS_SUPPORT_FAR_SIDE_H

#include <memory>
#include <string>

namespace berth
{

class far_side
{
  public:
    explicit far_side(const std::string &rig);
    ~far_side();
    far_side(const far_side &) = delete;
    far_side &operator=(const far_side &) = delete;

  private:
    struct process;
    std::unique_ptr<process> process_;
};

} // namespace berth

#endif
