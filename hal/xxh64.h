/* The checksum XXH64 with seed 0, of bytes that come in parts: libxxhash, of which the header alone is needed. It
 * takes a tenth of the time of a CRC-32 by tables, so that a log need not be slower for it. */
#ifndef HAL_XXH64_H
#define HAL_XXH64_H

#include <cstddef>
#include <cstdint>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace berth
{

class xxh64
{
  public:
    xxh64() { XXH64_reset(&state_, 0); }
    void add(const void *bytes, std::size_t size_bytes) { XXH64_update(&state_, bytes, size_bytes); }
    std::uint64_t value() const { return XXH64_digest(&state_); } /* of all that has been added */

  private:
    XXH64_state_t state_;
};

} // namespace berth

#endif
