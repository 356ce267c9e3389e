#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace metabuffer {

/// Throws the OutputError that says why a file cannot be written.
[[noreturn]] void fail_to_write(const std::filesystem::path& file, const std::string& why);

/// A file that appears only when it is whole. It is written aside, in the same folder under a unique name, until
/// put_in_place() gives it its own name. Before that an earlier file stays as it was. A symbolic link is followed to the
/// file that it names; the aside file is never opened through a link.
class OutputFile {
  public:
    /// Throws OutputError if nothing can be written there, or if what is there is not a regular file.
    explicit OutputFile(const std::filesystem::path& target);
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;
    ~OutputFile();

    /// Where it is written, for a library that writes files by their names.
    const std::filesystem::path& aside() const { return aside_; }
    /// Throws OutputError.
    void write(std::string_view bytes);
    /// Brings its content to the disk, whoever wrote it. Throws OutputError.
    void sync();
    /// Throws OutputError. Nothing can be written afterwards.
    void put_in_place();

  private:
    [[noreturn]] void fail(int error) const;
    void follow_links();
    void open_aside();

    std::filesystem::path name_;    ///< as the caller has it
    std::filesystem::path target_;  ///< the same, links followed
    std::filesystem::path aside_;
    int descriptor_ = -1;
    bool is_aside_ = false;
};

/// Puts a file of these bytes in place. Throws OutputError.
void write_output_file(const std::filesystem::path& file, std::string_view bytes);

}  // namespace metabuffer
