#pragma once

#include <filesystem>
#include <memory>

#include "host/child_process.h"
#include "host/output_file.h"

namespace metabuffer::rtl {

/// The file of a waveform. SystemC's writer opens a file by its name and never says whether what it wrote has arrived.
/// So it writes to a named pipe, and a process at the other end writes to the disk, checks that, and reports.
class WaveformFile {
  public:
    /// Construct it before this process elaborates anything. Throws OutputError or InputError.
    explicit WaveformFile(const std::filesystem::path& target);
    WaveformFile(const WaveformFile&) = delete;
    WaveformFile& operator=(const WaveformFile&) = delete;
    ~WaveformFile();

    /// The name that SystemC's writer is given; it adds the extension itself.
    std::string stem() const;
    /// As soon as SystemC has opened its file, which it does at its first clock: from then on it is no longer waited for if
    /// the other process ends before its time.
    void note_opened();
    /// After SystemC has closed its file: waits until all is written and puts it in place. Throws OutputError.
    void put_in_place();

  private:
    /// A folder of this process alone with the pipe in it.
    class Pipe;

    std::filesystem::path target_;
    OutputFile output_;
    std::unique_ptr<Pipe> pipe_;
    std::unique_ptr<ChildProcess> writer_;
};

}  // namespace metabuffer::rtl
