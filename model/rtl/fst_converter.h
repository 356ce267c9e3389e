#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>

#include "host/filter_process.h"
#include "host/output_file.h"
#include "host/temporary_folder.h"

namespace metabuffer::rtl {

/// Converts a value change dump to FST, GTKWave's compressed waveform, by GTKWave's own vcd2fst.
class FstConverter {
  public:
    /// Throws OutputError if vcd2fst is not on this computer.
    static void check_installed(const std::filesystem::path& target);

    /// Throws OutputError.
    FstConverter();
    FstConverter(const FstConverter&) = delete;
    FstConverter& operator=(const FstConverter&) = delete;

    /// Takes the next part of the value change dump.
    void write(std::string_view bytes) { process_->feed(bytes); }
    /// Call it after the dump's end: writes the result. Throws OutputError, also if the file is not whole, since
    /// vcd2fst does not notice a full disk.
    void finish(OutputFile& output);

  private:
    std::filesystem::path made_file() const { return folder_->path() / "waveform.fst"; }

    std::optional<TemporaryFolder> folder_;   ///< vcd2fst writes files by name
    std::unique_ptr<FilterProcess> process_;  ///< after folder_, so that it ends before its folder is removed
};

}  // namespace metabuffer::rtl
