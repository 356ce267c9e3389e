#pragma once

#include <filesystem>

namespace metabuffer {

/// A folder for temporary files of this object. It is removed with the object, and with it all files in it.
class TemporaryFolder {
  public:
    /// Throws std::system_error if none can be made.
    TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder();

    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

}  // namespace metabuffer
