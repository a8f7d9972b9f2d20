// node validate.js FILE.glb: prints what the Khronos glTF validator says; exit 1 on any error.
const fs = require("fs");
const validator = require("gltf-validator");

const severities = ["error", "warning", "information", "hint"];

validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[2])), { maxIssues: 100 }).then((report) => {
  for (const issue of report.issues.messages) {
    console.log(`${severities[issue.severity]}: ${issue.pointer}: ${issue.message}`);
  }
  const { numErrors, numWarnings } = report.issues;
  console.log(`${process.argv[2]}: ${numErrors} errors, ${numWarnings} warnings`);
  process.exit(numErrors === 0 ? 0 : 1);
}).catch((reason) => {
  console.error(`${process.argv[2]}: cannot be validated: ${reason}`);
  process.exit(1);
});
