/* The rows of a map, shared out among threads. */
#ifndef SIM_HAL_STABILITY_SHARED_ROWS_H
#define SIM_HAL_STABILITY_SHARED_ROWS_H

#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace berth
{

/* `make_worker` is called once in each thread; what it returns is called with the number of one row after another,
 * so that it can keep what rows have in common. `rows_done` is called now and then from the calling thread. */
template <class MakeWorker>
void share_rows(int rows, int threads, const std::function<void(int)> &rows_done, const MakeWorker &make_worker)
{
    std::atomic<int> next_row{0};
    std::atomic<int> done{0};
    const auto work = [&](bool reports) {
        auto worker = make_worker();
        for (int row = next_row++; row < rows; row = next_row++) {
            worker(row);
            done++;
            if (reports && rows_done) {
                rows_done(done);
            }
        }
    };
    std::vector<std::thread> others;
    for (int i = 1; i < threads; i++) {
        others.emplace_back(work, false);
    }
    work(true);
    for (std::thread &other : others) {
        other.join();
    }
}

} // namespace berth

#endif
