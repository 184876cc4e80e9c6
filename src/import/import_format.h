#pragma once
#include <string>
#include <vector>

#include "import/column_mapping.h"
#include "import/import_file.h"
#include "import/text_file.h"
#include "session/input_faults.h"

namespace mm {

/// All that a format needs to make a session.
struct ImportContext {
  const TextFile& file;
  const ColumnMapping& mapping;
  const Machine& machine;
  const Artifact* artifact;  // null: none was given
  FaultList& faults;
  Imported& imported;
};

/// A kind of file that is recognised by itself.
struct ImportFormat {
  const char* name;  // of --format
  const char* what;  // in a few words
  bool (*recognises)(const TextFile& file);
  void (*read)(ImportContext& context);  // fills imported.session, or adds faults
};

/// In the order in which they are tried; `table` takes what no other recognises.
const std::vector<ImportFormat>& importFormats();

/// Makes a session ready: order, checks, assumed directions of travel; and the motions that tell a bag of the
/// directions of readings at standstill. @throw InputError as Session::prepare.
void finishImport(ImportContext& context, Session session);

/// A session without rows, from this file.
Session emptySession(const ImportContext& context);

}  // namespace mm
