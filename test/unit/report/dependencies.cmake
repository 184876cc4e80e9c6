set(report_test_dependencies uncertainty compensation workflow design model nlohmann_json::nlohmann_json)
