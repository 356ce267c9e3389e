#pragma once

#include <string>

#include "tools/exploration/results_database.h"

namespace metabuffer::exploration {

/// CSV as RFC 4180 has it, the columns' names first; nothing is an empty field.
std::string csv_text(const ResultsReader::Table& table);

/// A JSON array with an object for each row; nothing is null. Texts that are not UTF-8 are mended.
std::string json_text(const ResultsReader::Table& table);

}  // namespace metabuffer::exploration
