#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>

#include "host/filter_process.h"
#include "host/output_file.h"
#include "host/temporary_folder.h"

namespace metabuffer::rtl {

/// Makes GTKWave's compressed waveform, FST, of a value change dump, by GTKWave's own vcd2fst.
class FstConverter {
  public:
    /// Throws OutputError if the program that does it is not on this computer.
    static void check_installed(const std::filesystem::path& target);

    /// Throws OutputError.
    FstConverter();
    FstConverter(const FstConverter&) = delete;
    FstConverter& operator=(const FstConverter&) = delete;

    /// A part of the value change dump.
    void write(std::string_view bytes) { process_->feed(bytes); }
    /// After its end: writes what has come of it. Throws OutputError, also if the file is not whole: vcd2fst does not
    /// notice a full disk.
    void finish(OutputFile& output);

  private:
    std::filesystem::path made_file() const { return folder_->path() / "waveform.fst"; }

    std::optional<TemporaryFolder> folder_;   ///< vcd2fst writes files by name
    std::unique_ptr<FilterProcess> process_;  // ends before the folder goes
};

}  // namespace metabuffer::rtl
