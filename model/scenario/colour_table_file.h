#pragma once

#include <filesystem>
#include <string>

#include "formats/colour_table.h"

/// Files of colour tables: 256 rows of R, G and B as CSV, the first for the value 0. Values are whole numbers, 0 to 255.
namespace metabuffer::input {

/// Throws InputError if it cannot be read or is not such a file; it names the file, and the line that is wrong.
ColourTable read_colour_table(const std::filesystem::path& file);

/// The same from text; `origin` names it in messages.
ColourTable parse_colour_table(const std::string& text, const std::string& origin);

/// What parse_colour_table() reads as that table.
std::string colour_table_text(const ColourTable& table);

}  // namespace metabuffer::input
