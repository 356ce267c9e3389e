#include "scenario/colour_table_file.h"

#include <charconv>
#include <cstdint>
#include <string_view>
#include <system_error>
#include <vector>

#include "host/errors.h"
#include "host/text.h"
#include "host/text_file.h"

namespace metabuffer::input {
namespace {

/// Many times as much as 256 rows with spaces in them take.
constexpr std::uintmax_t kLongestTableBytes = std::uintmax_t{64} << 10U;

constexpr const char* kUse = "; use 256 rows of R,G,B, each a whole number, 0 to 255";

std::string_view trimmed(std::string_view words) {
    constexpr std::string_view kSpace = " \t\r";
    const std::size_t first = words.find_first_not_of(kSpace);
    if (first == std::string_view::npos) return {};
    return words.substr(first, words.find_last_not_of(kSpace) - first + 1);
}

/// The parts between the marks; one more than there are marks.
std::vector<std::string_view> parts_of(std::string_view text, char mark) {
    std::vector<std::string_view> parts;
    for (;;) {
        const std::size_t end = text.find(mark);
        parts.push_back(trimmed(text.substr(0, end)));
        if (end == std::string_view::npos) return parts;
        text.remove_prefix(end + 1);
    }
}

class TableText {
  public:
    explicit TableText(const std::string& origin) : origin_(origin) {}

    [[noreturn]] void fail(const std::string& fault) const {
        throw InputError(text::one_line(origin_ + ": " + fault + kUse));
    }
    [[noreturn]] void fail(std::size_t line, const std::string& fault) const {
        throw InputError(text::one_line(origin_ + ":" + std::to_string(line) + ": " + fault + kUse));
    }
    std::uint8_t value(std::size_t line, std::string_view digits) const {
        std::uint8_t number = 0;
        const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
        if (error != std::errc() || stop != digits.data() + digits.size()) {
            fail(line, text::quoted(digits) + " is not a value of a colour");
        }
        return number;
    }

  private:
    const std::string& origin_;
};

}  // namespace

ColourTable parse_colour_table(const std::string& text, const std::string& origin) {
    const TableText table(origin);
    std::vector<std::string_view> lines = parts_of(text, '\n');
    while (!lines.empty() && lines.back().empty()) lines.pop_back();
    ColourTable::Channels channels{};
    for (std::size_t row = 0; row < lines.size() && row < ColourTable::kValues; ++row) {
        const std::vector<std::string_view> values = parts_of(lines[row], ',');
        if (values.size() != ColourTable::kChannels) {
            table.fail(row + 1, "has " + text::counted(values.size(), "value"));
        }
        for (std::size_t c = 0; c < ColourTable::kChannels; ++c) {
            channels[c][row] = table.value(row + 1, values[c]);
        }
    }
    if (lines.size() != ColourTable::kValues) table.fail("has " + text::counted(lines.size(), "row"));
    return ColourTable(channels);
}

ColourTable read_colour_table(const std::filesystem::path& file) {
    return parse_colour_table(text_of_file(file, kLongestTableBytes), file.string());
}

std::string colour_table_text(const ColourTable& table) {
    std::string text;
    for (std::size_t v = 0; v < ColourTable::kValues; ++v) {
        for (std::size_t c = 0; c < ColourTable::kChannels; ++c) {
            text += (c == 0 ? "" : ",") + std::to_string(table.channels()[c][v]);
        }
        text += '\n';
    }
    return text;
}

}  // namespace metabuffer::input
