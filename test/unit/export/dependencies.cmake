set(export_test_dependencies compensation nlohmann_json::nlohmann_json gmock)
