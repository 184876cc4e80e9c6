set(import_test_dependencies gmock)
