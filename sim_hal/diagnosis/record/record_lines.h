/* The lines of a text file, plain or packed (.gz), one by one: only what a reader keeps of them takes memory. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_RECORD_LINES_H
#define SIM_HAL_DIAGNOSIS_RECORD_RECORD_LINES_H

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace berth
{

class unpacker;

/* Reads a file or a pipe once, and no further than lines are asked for. Lines may end in LF, CR LF or CR. Throws
 * input_error. */
class record_lines
{
  public:
    explicit record_lines(const std::string &path);
    ~record_lines();

    /* False: there is no other one. Valid until the next one is asked for. */
    bool next(std::string_view &line);

    /* Of the line that next() told of, as an editor counts; from 1. */
    long number() const { return number_; }

    /* text_hash() of the bytes in the file, packed or not; of all once next() was false. */
    std::string hash() const;

  private:
    /* Appends some text; false: the file has ended. */
    bool fill();
    bool read_stored();
    void append(std::string_view text);

    struct closer {
        void operator()(std::FILE *file) const { std::fclose(file); }
    };
    std::unique_ptr<std::FILE, closer> file_;
    std::unique_ptr<unpacker> unpacker_; /* nullptr: plain text */
    std::string path_;
    std::string stored_; /* read, and not made text yet */
    std::string buffer_; /* text, from at_ on not told yet */
    std::size_t at_ = 0;
    std::size_t text_bytes_ = 0;
    long number_ = 0;
    bool was_return_ = false; /* the last character: a line feed after it belongs to it */
    std::uint64_t hash_ = 0xcbf29ce484222325u;
};

} // namespace berth

#endif
