#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "host/child_process.h"
#include "host/output_file.h"

namespace metabuffer::rtl {

/// What the names of waveforms end in.
inline constexpr const char* kWaveformExtension = ".vcd";
inline constexpr const char* kCompressedWaveformExtension = ".fst";
bool is_waveform_name(const std::filesystem::path& file);

/// The file of a waveform. SystemC's writer opens a file by its name and never reports an error: what a full disk refuses
/// is missing in the middle of the file. So SystemC writes to a named pipe, and a process at the other end writes to the
/// disk and reports errors.
class WaveformFile {
  public:
    /// A target whose name ends in .fst is written in GTKWave's compressed format, another one as a value change dump.
    /// header: lines that the file begins with, as a comment. Throws OutputError or InputError.
    WaveformFile(const std::filesystem::path& target, const std::string& header);
    WaveformFile(const WaveformFile&) = delete;
    WaveformFile& operator=(const WaveformFile&) = delete;
    ~WaveformFile();

    /// Starts the process that writes. Call it as late as possible, but before this process elaborates anything.
    /// first_picoseconds: the time that the first values belong to. Throws OutputError or InputError.
    void start(std::int64_t first_picoseconds);
    /// The name that SystemC's writer is given; it adds the extension itself.
    std::string stem() const;
    /// Call it as soon as SystemC has opened its file, which it does at its first clock. From then on SystemC does not
    /// wait for the other process if that ends early.
    void note_opened();
    /// Call it after SystemC has closed its file: waits until all is written and puts the file in place. Throws
    /// OutputError.
    void put_in_place();

  private:
    std::string write_all();

    /// The pipe, in a folder that only this process uses.
    class Pipe;

    std::filesystem::path target_;
    std::string header_;
    OutputFile output_;
    std::int64_t first_picoseconds_ = 0;
    std::unique_ptr<Pipe> pipe_;
    std::unique_ptr<ChildProcess> writer_;
};

}  // namespace metabuffer::rtl
