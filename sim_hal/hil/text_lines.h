/* The lines of a text file, plain or packed (.gz), one by one: only what a reader keeps of them takes memory. */
#ifndef SIM_HAL_HIL_TEXT_LINES_H
#define SIM_HAL_HIL_TEXT_LINES_H

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace berth
{

class unpacker;

/* Reads a file or a pipe once, and no further than lines are asked for. Lines may end in LF, CR LF or CR. Text in
 * UTF-16 becomes UTF-8, and a byte order mark is left out. Throws input_error. */
class text_lines
{
  public:
    explicit text_lines(const std::string &path);
    ~text_lines();

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
    void take_bytes(std::string_view bytes);
    void take_utf16(std::string_view bytes);
    void append(std::string_view text);

    struct closer {
        void operator()(std::FILE *file) const { std::fclose(file); }
    };
    std::unique_ptr<std::FILE, closer> file_;
    std::unique_ptr<unpacker> unpacker_; /* nullptr: plain text */
    std::string path_;
    std::string stored_; /* read, and not unpacked yet */
    enum class encoding { unknown, utf8, utf16_little, utf16_big };
    encoding encoding_ = encoding::unknown;
    std::string undecoded_; /* unpacked; too few bytes to tell the encoding, or a part of a letter */
    std::string buffer_;    /* text, from at_ on not told yet */
    std::size_t at_ = 0;
    std::size_t text_bytes_ = 0;
    long number_ = 0;
    bool was_return_ = false; /* the last character: a line feed after it belongs to it */
    std::uint64_t hash_ = 0xcbf29ce484222325u;
};

} // namespace berth

#endif
