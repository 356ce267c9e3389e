#pragma once

#include <string>
#include <vector>

namespace metabuffer::rtl {

/// The words for the values of an enumeration in the waveform. GTKWave shows them by a translate file; waves/ has one
/// for each of these.
struct EnumerationNames {
    std::string signal;  ///< the end of its name in the waveform
    std::string file;    ///< in waves/translate
    std::vector<std::string> words;
    std::vector<std::string> values = {};  ///< of the words, as GTKWave shows them; empty: 0, 1, 2, ...
};

const std::vector<EnumerationNames>& enumeration_names();

}  // namespace metabuffer::rtl
