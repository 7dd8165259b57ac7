// The editor's side: starts `cspcheck lsp`, and opens a terminal for what is interactive.
"use strict";

const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

function commandLine() {
  const command = vscode.workspace.getConfiguration("cspcheck").get("command");
  return Array.isArray(command) && command.length > 0 ? command : ["cspcheck"];
}

function pathOf(uri) {
  return vscode.Uri.parse(uri).fsPath;
}

async function start() {
  const [program, ...first] = commandLine();
  client = new LanguageClient(
    "cspcheck",
    "cspcheck",
    { command: program, args: [...first, "lsp"] },
    {
      documentSelector: [
        { scheme: "file", language: "cspm" },
        { scheme: "untitled", language: "cspm" },
        { scheme: "file", language: "latex" }, // documents with classes; the server has nothing to say of others
        { scheme: "file", language: "tex" },
      ],
      middleware: {
        // Probing is interactive: it happens in a terminal, everything else in the server.
        executeCommand: async (command, args, next) => {
          if (command !== "cspcheck.probe") return next(command, args);
          const [uri, line] = args;
          const terminal = vscode.window.createTerminal({
            name: `probe ${line}`,
            shellPath: program,
            shellArgs: [...first, "probe", "--at", `${pathOf(uri)}:${line}`],
          });
          terminal.show();
          return undefined;
        },
      },
    },
  );
  try {
    await client.start();
  } catch (error) {
    vscode.window.showErrorMessage(
      `cspcheck did not start (${error.message}). Install it with: pip install "cspcheck[lsp]"`,
    );
  }
}

async function activate(context) {
  context.subscriptions.push(
    vscode.commands.registerCommand("cspcheck.checkAll", async () => {
      const editor = vscode.window.activeTextEditor;
      if (!editor || !["cspm", "latex", "tex"].includes(editor.document.languageId)) return;
      await editor.document.save();
      await vscode.commands.executeCommand("cspcheck.check", editor.document.uri.toString());
    }),
    vscode.commands.registerCommand("cspcheck.restart", async () => {
      if (client) await client.stop();
      await start();
    }),
  );
  await start();
}

function deactivate() {
  return client ? client.stop() : undefined;
}

module.exports = { activate, deactivate };
