#include "workbench/zip.h"

#include <archive.h>
#include <archive_entry.h>

#include <ctime>
#include <memory>

#include "base/error.h"

namespace mm {

std::string zipOf(const std::string& folder, const std::vector<ExportedFile>& files) {
  std::string zip;
  const auto take = [](archive*, void* to, const void* bytes, std::size_t count) {
    static_cast<std::string*>(to)->append(static_cast<const char*>(bytes), count);
    return static_cast<la_ssize_t>(count);
  };
  const std::unique_ptr<archive, decltype(&archive_write_free)> writer(archive_write_new(),
                                                                       archive_write_free);
  const auto check = [&](la_ssize_t status) {
    if (status < ARCHIVE_OK) throw InputError(folder + ".zip: " + archive_error_string(writer.get()));
  };
  check(archive_write_set_format_zip(writer.get()));
  check(archive_write_set_bytes_in_last_block(writer.get(), 1));  // no zeros behind the end
  check(archive_write_open(writer.get(), &zip, nullptr, take, nullptr));
  const std::unique_ptr<archive_entry, decltype(&archive_entry_free)> entry(archive_entry_new(),
                                                                            archive_entry_free);
  for (const ExportedFile& file : files) {
    archive_entry_clear(entry.get());
    archive_entry_set_pathname_utf8(entry.get(), (folder + "/" + file.path).c_str());
    archive_entry_set_size(entry.get(), static_cast<la_int64_t>(file.text.size()));
    archive_entry_set_filetype(entry.get(), AE_IFREG);
    archive_entry_set_perm(entry.get(), 0644);
    archive_entry_set_mtime(entry.get(), std::time(nullptr), 0);
    check(archive_write_header(writer.get(), entry.get()));
    check(archive_write_data(writer.get(), file.text.data(), file.text.size()));
  }
  check(archive_write_close(writer.get()));
  return zip;
}

}  // namespace mm
