#include "rtl/fst_converter.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

#include "host/errors.h"

namespace metabuffer::rtl {
namespace {

const FilterProgram& converter() {
    static const FilterProgram program{{"vcd2fst", "-"}, "gtkwave", "an FST waveform"};
    return program;
}

/// An FST file is a sequence of sections. Each begins with a byte for its kind and eight bytes for the length of the
/// rest, the eight included. A section that was not finished has no length.
bool is_whole(std::ifstream& file, std::uint64_t size) {
    std::uint64_t at = 0;
    while (at < size) {
        std::array<char, 9> head{};
        file.seekg(static_cast<std::streamoff>(at));
        if (!file.read(head.data(), head.size())) return false;
        std::uint64_t length = 0;
        for (std::size_t i = 1; i < head.size(); ++i) {
            length = length << 8U | static_cast<std::uint8_t>(head[i]);
        }
        if (length < head.size() - 1 || length > size - at - 1) return false;
        at += 1 + length;
    }
    return size > 0;
}

}  // namespace

void FstConverter::check_installed(const std::filesystem::path& target) {
    if (is_installed(converter())) return;
    fail_to_write(target, "there is no " + converter().command.front() + "; install Debian's package " +
                              converter().package + ", or name a FILE.vcd");
}

FstConverter::FstConverter() {
    try {
        folder_.emplace();
    } catch (const std::system_error& error) {
        throw OutputError(std::string("the waveform's folder: ") + error.what());
    }
    FilterProgram program = converter();
    program.command.push_back(made_file().string());
    process_ = std::make_unique<FilterProcess>(program);
}

void FstConverter::finish(OutputFile& output) {
    process_->finish();
    std::error_code error;
    const std::filesystem::path made = made_file();
    const std::uintmax_t size = std::filesystem::file_size(made, error);
    std::ifstream file(made, std::ios::binary);
    if (error || !file || !is_whole(file, size)) {
        throw OutputError("the waveform: " + converter().command.front() + " left half a file in '" +
                          folder_->path().parent_path().string() + "'; is there room on the disk?");
    }
    file.seekg(0);
    std::vector<char> buffer(std::size_t{1} << 16);
    std::uintmax_t copied = 0;
    while (file.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) || file.gcount() > 0) {
        output.write({buffer.data(), static_cast<std::size_t>(file.gcount())});
        copied += static_cast<std::uintmax_t>(file.gcount());
    }
    if (copied != size) throw OutputError("the waveform: '" + made.string() + "' cannot be read to its end");
}

}  // namespace metabuffer::rtl
