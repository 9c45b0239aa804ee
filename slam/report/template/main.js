[startTheme, showWarnings, showFacts, showCards, showTrajectory, errorPlots, showResults, showBoxes, axisPlots, sensorPlots,
  showTables, showTiming, runtimePlots, showSections].forEach(attempt);
