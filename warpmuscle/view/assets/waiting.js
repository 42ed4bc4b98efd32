// The page before there is a motion: what is being done, and the page anew once there is one.

class Waiting {
  constructor({ protocol }) {
    this.protocol = protocol;
    this.say("preparing");
    this.connect();
    setInterval(() => this.show(), 1000);
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/`, [this.protocol]);
    socket.onmessage = ({ data }) => {
      const { words, failed } = typeof data === "string" ? JSON.parse(data) : {};
      if (failed !== undefined) this.failed = failed;
      if (words === undefined && failed === undefined) location.reload();
      else this.say(failed ?? words);
    };
    socket.onclose = () => {
      if (this.failed === undefined) this.say("The command that shows this has ended.");
      setTimeout(() => this.connect(), AGAIN);
    };
  }

  say(words) {
    if (words !== this.words) this.since = performance.now();
    this.words = words;
    this.show();
  }

  show() {
    const seconds = Math.floor((performance.now() - this.since) / 1000);
    tell(seconds && this.failed === undefined ? `${this.words}, ${seconds} s` : this.words);
  }
}
